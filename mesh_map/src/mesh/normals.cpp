#include "mesh/normals.h"

#include <mesh_map/base/parallel.h>

#include <cmath>

#include "base/vector3.h"

namespace mesh_map {
namespace {

constexpr std::size_t ITEMS_PER_CHUNK = 32768;

/// Two sides of a face. Differences of floats and their products are exact enough in double that a
/// face far from the origin has the same normal as near it.
struct Sides
{
  Sides(const MeshView& mesh, std::size_t face)
  {
    const auto corner = [&mesh, face](std::size_t k) {
      return mesh.positions.data() + 3 * std::size_t{mesh.faces[3 * face + k]};
    };
    ab = difference(corner(1), corner(0));
    ac = difference(corner(2), corner(0));
  }

  Vector3 ab, ac;
};

/// False where there is no direction: that of the fallback is stored.
bool store(const Vector3& vector, const std::array<float, 3>& fallback, float* normal)
{
  const double norm = std::sqrt(dot(vector, vector));
  const bool good = norm > 0.0 && std::isfinite(norm);
  for (unsigned axis = 0; axis < 3; ++axis) {
    normal[axis] = good ? static_cast<float>(vector[axis] / norm) : fallback[axis];
  }
  return good;
}

double cornerAngle(const Vector3& a, const Vector3& b)
{
  const Vector3 normal = cross(a, b);
  return std::atan2(std::sqrt(dot(normal, normal)), dot(a, b) + 0.0);  // no angle of -0 is pi
}

}  // namespace

FaceNormals faceNormals(const MeshView& mesh, const std::array<float, 3>& fallback,
                        unsigned threads)
{
  FaceNormals result;
  result.normals.resize(3 * mesh.faceCount());
  result.without_area.resize(mesh.faceCount());
  parallelFor(mesh.faceCount(), ITEMS_PER_CHUNK, threads, [&]() -> RangeBody {
    return [mesh, fallback, out = result.normals.data(), flags = result.without_area.data()](
               std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        const Sides sides(mesh, f);
        flags[f] = !store(cross(sides.ab, sides.ac), fallback, out + 3 * f);
      }
    };
  });
  return result;
}

std::vector<float> cornerAngles(const MeshView& mesh, unsigned threads)
{
  std::vector<float> angles(3 * mesh.faceCount());
  parallelFor(mesh.faceCount(), ITEMS_PER_CHUNK, threads, [&]() -> RangeBody {
    return [mesh, out = angles.data()](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        const Sides sides(mesh, f);
        const Vector3 bc = sides.ac - sides.ab;
        const Vector3 ba = {-sides.ab[0], -sides.ab[1], -sides.ab[2]};
        out[3 * f] = static_cast<float>(cornerAngle(sides.ab, sides.ac));
        out[3 * f + 1] = static_cast<float>(cornerAngle(ba, bc));
        out[3 * f + 2] = static_cast<float>(cornerAngle(sides.ac, bc));  // both turned round
      }
    };
  });
  return angles;
}

std::vector<float> vertexNormals(const VertexNormalsInput& input, unsigned threads)
{
  std::vector<float> normals(3 * input.vertex_faces.rowCount());
  parallelFor(input.vertex_faces.rowCount(), ITEMS_PER_CHUNK, threads, [&]() -> RangeBody {
    return [in = input, out = normals.data()](std::size_t begin, std::size_t end) {
      const std::uint32_t* const offsets = in.vertex_faces.offsets.data();
      for (std::size_t v = begin; v < end; ++v) {
        Vector3 sum = {0.0, 0.0, 0.0};
        for (std::uint32_t i = offsets[v]; i < offsets[v + 1]; ++i) {
          const std::size_t face = in.vertex_faces.values[i];
          if (in.ignored[face]) {
            continue;
          }
          double weight = 1.0;
          if (!in.corner_angles.empty()) {
            const std::uint32_t* const corners = in.faces.data() + 3 * face;
            const unsigned k = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
            weight = in.corner_angles[3 * face + k];
          }
          for (unsigned axis = 0; axis < 3; ++axis) {
            sum[axis] += weight * in.face_normals[3 * face + axis];
          }
        }
        store(sum, in.fallback, out + 3 * v);
      }
    };
  });
  return normals;
}

}  // namespace mesh_map
