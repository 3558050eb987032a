#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Coordinates as Eigen computes with them, in double precision; and back.
template <class Number>
Eigen::Vector3d vectorOf(const std::array<Number, 3>& coordinates)
{
  return {coordinates[0], coordinates[1], coordinates[2]};
}

inline std::array<double, 3> arrayOf(const Eigen::Vector3d& vector)
{
  return {vector[0], vector[1], vector[2]};
}

/// Between two points.
template <class One, class Other>
double distance(const std::array<One, 3>& a, const std::array<Other, 3>& b)
{
  return (vectorOf(a) - vectorOf(b)).norm();
}

inline const std::array<float, 3>& cornerOf(const MeshData& mesh, std::uint32_t face,
                                            std::size_t corner)
{
  return mesh.vertices[mesh.indices[3 * std::size_t{face} + corner]].position;
}

/// Twice as long as the area of the face, to the side from which it is counterclockwise.
inline Eigen::Vector3d normalOf(const MeshData& mesh, std::uint32_t face)
{
  const Eigen::Vector3d origin = vectorOf(cornerOf(mesh, face, 0));
  return (vectorOf(cornerOf(mesh, face, 1)) - origin)
      .cross(vectorOf(cornerOf(mesh, face, 2)) - origin);
}

/// Equal for equal positions.
inline std::uint64_t hashOf(const std::array<float, 3>& position)
{
  std::uint64_t hash = 0;
  for (const float coordinate : position) {
    const float normal = coordinate + 0.0f;  // -0 is 0
    std::uint32_t bits;
    std::memcpy(&bits, &normal, sizeof(bits));
    hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 29;
  }
  return hash;
}

/// x, y, z of each vertex, as mesh_map wants them.
inline std::vector<float> positionsOf(const MeshData& mesh)
{
  std::vector<float> positions;
  positions.reserve(3 * mesh.vertexCount());
  for (const MeshVertex& vertex : mesh.vertices) {
    positions.insert(positions.end(), vertex.position.begin(), vertex.position.end());
  }
  return positions;
}

}  // namespace rviz_mesh_plugin
