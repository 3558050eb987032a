#include "rviz_mesh_plugin/mesh_conversion.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "rviz_mesh_plugin/validation.h"

namespace rviz_mesh_plugin {
namespace {

using Vector = std::array<double, 3>;

template <class Message>
void refuseInvalid(const Message& message)
{
  const auto findings = check(message);
  if (!findings.empty()) {
    throw RejectedMessage(summarize(findings));
  }
}

template <class Point>
std::array<float, 3> toFloats(const Point& point)
{
  return {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z)};
}

Vector difference(const std::array<float, 3>& a, const std::array<float, 3>& b)
{
  return {double(a[0]) - b[0], double(a[1]) - b[1], double(a[2]) - b[2]};
}

Vector cross(const Vector& a, const Vector& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// In double: the squares of small sums underflow in float.
std::array<float, 3> unitOrZero(const Vector& v)
{
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!(length > 0.0) || !std::isfinite(length)) {
    return {0.0f, 0.0f, 0.0f};
  }
  return {static_cast<float>(v[0] / length), static_cast<float>(v[1] / length),
          static_cast<float>(v[2] / length)};
}

void setBounds(MeshData& mesh)
{
  mesh.lower = mesh.upper = mesh.vertices.front().position;
  for (const MeshVertex& vertex : mesh.vertices) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      mesh.lower[axis] = std::min(mesh.lower[axis], vertex.position[axis]);
      mesh.upper[axis] = std::max(mesh.upper[axis], vertex.position[axis]);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float extent = std::max(-mesh.lower[axis], mesh.upper[axis]);
    if (extent > GREATEST_COORDINATE) {
      throw RejectedMessage(
          "a coordinate is " + std::to_string(extent) +
          " m from the origin of its frame, too far to be drawn; choose a nearer origin");
    }
  }
}

}  // namespace

void computeNormals(MeshData& mesh)
{
  std::vector<Vector> sums(mesh.vertices.size(), Vector{});
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const auto& origin = mesh.vertices[mesh.indices[i]].position;
    // The length of the cross product is twice the area: the weight.
    const Vector normal = cross(difference(mesh.vertices[mesh.indices[i + 1]].position, origin),
                                difference(mesh.vertices[mesh.indices[i + 2]].position, origin));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Vector& sum = sums[mesh.indices[i + corner]];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        sum[axis] += normal[axis];
      }
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    mesh.vertices[i].normal = unitOrZero(sums[i]);
  }
}

MeshDataConstPtr convert(const mesh_msgs::MeshGeometryStamped& message)
{
  refuseInvalid(message);
  const auto& geometry = message.mesh_geometry;
  auto mesh = std::make_shared<MeshData>();
  mesh->uuid = message.uuid;
  mesh->frame_id = message.header.frame_id;
  mesh->vertices.resize(geometry.vertices.size());
  for (std::size_t i = 0; i < geometry.vertices.size(); ++i) {
    mesh->vertices[i].position = toFloats(geometry.vertices[i]);
  }
  setBounds(*mesh);
  mesh->indices.reserve(3 * geometry.faces.size());
  for (const auto& face : geometry.faces) {
    mesh->indices.insert(mesh->indices.end(), face.vertex_indices.begin(),
                         face.vertex_indices.end());
  }
  mesh->normals_given = !geometry.vertex_normals.empty();
  if (mesh->normals_given) {
    for (std::size_t i = 0; i < geometry.vertex_normals.size(); ++i) {
      const auto& normal = geometry.vertex_normals[i];
      mesh->vertices[i].normal = unitOrZero({normal.x, normal.y, normal.z});
    }
  } else {
    computeNormals(*mesh);
  }
  return mesh;
}

CostLayerConstPtr convert(const mesh_msgs::MeshVertexCostsStamped& message)
{
  refuseInvalid(message);
  auto layer = std::make_shared<CostLayer>();
  layer->uuid = message.uuid;
  layer->type = message.type;
  layer->costs = message.mesh_vertex_costs.costs;
  layer->summary = summarizeCosts(layer->costs);
  return layer;
}

ColorLayerConstPtr convert(const mesh_msgs::MeshVertexColorsStamped& message)
{
  refuseInvalid(message);
  auto layer = std::make_shared<ColorLayer>();
  layer->uuid = message.uuid;
  layer->colors.reserve(message.mesh_vertex_colors.vertex_colors.size());
  const auto toByte = [](float channel) {
    return static_cast<std::uint8_t>(channel * 255.0f + 0.5f);
  };
  for (const auto& color : message.mesh_vertex_colors.vertex_colors) {
    layer->colors.push_back({toByte(color.r), toByte(color.g), toByte(color.b), toByte(color.a)});
  }
  return layer;
}

}  // namespace rviz_mesh_plugin
