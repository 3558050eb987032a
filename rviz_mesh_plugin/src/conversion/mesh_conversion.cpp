#include "conversion/mesh_conversion.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/geometry_identity.h"
#include "base/vectors.h"
#include "conversion/geometry_remark.h"
#include "conversion/validation.h"

namespace rviz_mesh_plugin {
namespace {

/// Vertices or faces that one core works on at a time.
constexpr std::size_t RUN = 65536;

template <class Point>
std::array<float, 3> toFloats(const Point& point)
{
  return {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z)};
}

bool isFiniteVector(const std::array<float, 3>& v)
{
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

/// In double: the squares of small sums underflow in float.
std::array<float, 3> unitOrZero(const Eigen::Vector3d& v)
{
  const double length = v.norm();
  if (!(length > 0.0) || !std::isfinite(length)) {
    return {0.0f, 0.0f, 0.0f};
  }
  const Eigen::Vector3f unit = (v / length).cast<float>();
  return {unit[0], unit[1], unit[2]};
}

template <class Point>
std::array<float, 3> toUnit(const Point& normal)
{
  return unitOrZero({normal.x, normal.y, normal.z});
}

/// Tells -0 from 0.
bool sameBits(const std::array<float, 3>& a, const std::array<float, 3>& b)
{
  return std::memcmp(a.data(), b.data(), sizeof(a)) == 0;
}

/// What is seen of a message while it is converted.
struct Survey
{
  bool valid = true;
  Bounds bounds = Bounds::none();
  std::uint64_t hash = 0;  ///< of the geometry

  void add(const Survey& other)
  {
    valid = valid && other.valid;
    bounds.enclose(other.bounds);
    hash += other.hash;
  }
};

/// Adds up the surveys that @a convert(index, survey) makes on all cores.
template <class Convert>
Survey surveyEach(std::size_t count, const Convert& convert)
{
  Survey sum;
  std::mutex mutex;
  mesh_map::parallelFor(count, RUN, 0, [&]() -> mesh_map::RangeBody {
    return [&sum, &mutex, convert](std::size_t begin, std::size_t end) {
      Survey part;
      for (std::size_t i = begin; i < end; ++i) {
        convert(i, part);
      }
      const std::lock_guard<std::mutex> lock(mutex);
      sum.add(part);
    };
  });
  return sum;
}

/// Positions, indices and normals if there are as many as vertices. Is not valid where check()
/// would find something in these.
Survey convertNumbers(const mesh_msgs::MeshGeometry& geometry, MeshData& mesh)
{
  // Memory is cleared, page by page, which takes as long as to fill it.
  mesh_map::parallelJobs({[&]() { mesh.vertices.resize(geometry.vertices.size()); },
                          [&]() { mesh.indices.resize(3 * geometry.faces.size()); }},
                         2);
  const auto* normals = mesh.normals_given ? geometry.vertex_normals.data() : nullptr;
  Survey survey =
      surveyEach(mesh.vertices.size(), [from = geometry.vertices.data(), normals,
                                        to = mesh.vertices.data()](std::size_t i, Survey& part) {
        to[i].position = toFloats(from[i]);
        part.valid = part.valid && isFiniteVector(to[i].position);
        part.bounds.enclose(to[i].position);
        part.hash += vertexHash(i, to[i].position);
        if (normals != nullptr) {
          part.valid = part.valid && isFiniteVector(toFloats(normals[i]));
          to[i].normal = toUnit(normals[i]);
        }
      });
  survey.add(surveyEach(
      geometry.faces.size(), [from = geometry.faces.data(), to = mesh.indices.data(),
                              count = mesh.vertices.size()](std::size_t i, Survey& part) {
        const auto& corners = from[i].vertex_indices;
        part.valid = part.valid && corners[0] < count && corners[1] < count && corners[2] < count;
        std::copy(corners.begin(), corners.end(), to + 3 * i);
        part.hash += faceHash(i, to + 3 * i);
      }));
  return survey;
}

void setBounds(MeshData& mesh, const Bounds& bounds)
{
  static_cast<Bounds&>(mesh) = bounds;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float extent = std::max(-mesh.lower[axis], mesh.upper[axis]);
    if (extent > GREATEST_COORDINATE) {
      throw RejectedMessage(
          "a coordinate is " + std::to_string(extent) +
          " m from the origin of its frame, too far to be drawn; choose a nearer origin");
    }
  }
}

/// The length of a normal is twice the area: the weight.
void addNormals(const MeshData& mesh, std::size_t first_face, std::size_t last_face,
                std::vector<Eigen::Vector3d>& sums)
{
  sums.assign(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (std::size_t face = first_face; face < last_face; ++face) {
    const Eigen::Vector3d normal = normalOf(mesh, static_cast<std::uint32_t>(face));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      sums[mesh.indices[3 * face + corner]] += normal;
    }
  }
}

}  // namespace

void computeNormals(MeshData& mesh)
{
  // Always in two halves, so that a mesh has the same normals to the last bit on any machine.
  std::array<std::vector<Eigen::Vector3d>, 2> halves;
  const std::size_t count = mesh.faceCount();
  mesh_map::parallelJobs({[&]() { addNormals(mesh, 0, count / 2, halves[0]); },
                          [&]() { addNormals(mesh, count / 2, count, halves[1]); }},
                         2);
  mesh_map::parallelEach(
      mesh.vertices.size(), RUN, 0,
      [a = halves[0].data(), b = halves[1].data(), vertices = mesh.vertices.data()](std::size_t i) {
        vertices[i].normal = unitOrZero(a[i] + b[i]);
      });
}

std::atomic<std::size_t> conversions{0};

MeshDataConstPtr convert(const mesh_msgs::MeshGeometryStamped& message)
{
  ++conversions;
  const auto& geometry = message.mesh_geometry;
  auto mesh = std::make_shared<MeshData>();
  mesh->uuid = message.uuid;
  mesh->frame_id = message.header.frame_id;
  mesh->normals_given = !geometry.vertex_normals.empty();
  const bool plain = !message.header.frame_id.empty() && !geometry.vertices.empty() &&
                     !geometry.faces.empty() &&
                     (geometry.vertex_normals.empty() ||
                      geometry.vertex_normals.size() == geometry.vertices.size());
  Survey survey;
  survey.valid = plain;
  if (plain) {
    survey.add(convertNumbers(geometry, *mesh));
  }
  // The full check, on one core, takes longer than everything else here.
  if (!survey.valid) {
    refuse(check(message));
    throw std::logic_error("a mesh that breaks no rule has been found invalid");
  }
  setBounds(*mesh, survey.bounds);
  mesh->geometry_hash = survey.hash;
  if (!mesh->normals_given) {
    computeNormals(*mesh);
  }
  mesh->remark = findRemark(geometry, *mesh);
  return mesh;
}

bool isConverted(const mesh_msgs::MeshGeometryStamped& message, const MeshData& mesh)
{
  const auto& geometry = message.mesh_geometry;
  if (message.uuid != mesh.uuid || message.header.frame_id != mesh.frame_id ||
      geometry.vertices.size() != mesh.vertexCount() || geometry.faces.size() != mesh.faceCount() ||
      geometry.vertex_normals.size() != (mesh.normals_given ? mesh.vertexCount() : 0)) {
    return false;
  }
  const auto* normals = mesh.normals_given ? geometry.vertex_normals.data() : nullptr;
  const Survey vertices =
      surveyEach(mesh.vertices.size(), [from = geometry.vertices.data(), normals,
                                        to = mesh.vertices.data()](std::size_t i, Survey& part) {
        part.valid = part.valid && sameBits(toFloats(from[i]), to[i].position) &&
                     (normals == nullptr || sameBits(toUnit(normals[i]), to[i].normal));
      });
  // Where no normals are given, they are those of positions and faces.
  return vertices.valid &&
         surveyEach(mesh.faceCount(), [from = geometry.faces.data(), to = mesh.indices.data()](
                                          std::size_t i, Survey& part) {
           const auto& corners = from[i].vertex_indices;
           part.valid = part.valid && std::equal(corners.begin(), corners.end(), to + 3 * i);
         }).valid;
}

}  // namespace rviz_mesh_plugin
