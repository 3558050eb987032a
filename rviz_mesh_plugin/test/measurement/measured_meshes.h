#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/mesh_data.h"
#include "base/vectors.h"
#include "conversion/mesh_conversion.h"
#include "picking/surface_paths.h"
#include "support/meshes.h"

/// Meshes of which lengths and areas are known, and points on them.
namespace measured_meshes {

using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::SurfacePoint;
using Vector = std::array<double, 3>;

/// Of the generated meshes of mesh_msgs, see write_world.py.
inline MeshData world(const std::string& name)
{
  const std::string path = "measured_" + name + ".bin";
  const std::string command = "/usr/bin/python3 '" WRITE_WORLD "' " + name + " " + path;
  if (std::system(command.c_str()) != 0) {
    throw std::runtime_error(command);
  }
  std::ifstream file(path, std::ios::binary);
  std::array<std::uint32_t, 2> counts{};
  file.read(reinterpret_cast<char*>(counts.data()), sizeof(counts));
  MeshData mesh;
  mesh.vertices.resize(counts[0]);
  for (auto& vertex : mesh.vertices) {
    file.read(reinterpret_cast<char*>(vertex.position.data()), sizeof(vertex.position));
  }
  mesh.indices.resize(3 * std::size_t{counts[1]});
  file.read(reinterpret_cast<char*>(mesh.indices.data()),
            static_cast<std::streamsize>(sizeof(std::uint32_t) * mesh.indices.size()));
  if (!file) {
    throw std::runtime_error(path + " is short");
  }
  return mesh;
}

template <class Height>
MeshData terrain(std::uint32_t cells, const Height& height)
{
  return *rviz_mesh_plugin::convert(test_meshes::terrain(cells, height));
}

/// Adds the four corners of a quadrilateral, counterclockwise.
inline void addQuad(MeshData& mesh, const std::array<std::array<float, 3>, 4>& corners)
{
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const auto& corner : corners) {
    mesh.vertices.push_back({corner, {}});
  }
  for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) {
    mesh.indices.push_back(first + corner);
  }
}

/// Adds a closed box, seen from outside.
inline void addBox(MeshData& mesh, const std::array<float, 3>& low,
                   const std::array<float, 3>& high)
{
  const auto [a, b, c] = low;
  const auto [x, y, z] = high;
  addQuad(mesh, {{{a, b, z}, {x, b, z}, {x, y, z}, {a, y, z}}});
  addQuad(mesh, {{{a, y, c}, {x, y, c}, {x, b, c}, {a, b, c}}});
  addQuad(mesh, {{{a, b, c}, {x, b, c}, {x, b, z}, {a, b, z}}});
  addQuad(mesh, {{{x, y, c}, {a, y, c}, {a, y, z}, {x, y, z}}});
  addQuad(mesh, {{{x, b, c}, {x, y, c}, {x, y, z}, {x, b, z}}});
  addQuad(mesh, {{{a, y, c}, {a, b, c}, {a, b, z}, {a, y, z}}});
}

inline MeshData without(MeshData mesh, const std::vector<std::uint32_t>& faces)
{
  for (auto face = faces.rbegin(); face != faces.rend(); ++face) {
    mesh.indices.erase(mesh.indices.begin() + 3 * *face, mesh.indices.begin() + 3 * *face + 3);
  }
  return mesh;
}

/// All heights of a mesh above x and y, with their faces.
inline std::vector<std::pair<double, std::uint32_t>> heightsAt(const MeshData& mesh, double x,
                                                               double y)
{
  using rviz_mesh_plugin::cornerOf;
  std::vector<std::pair<double, std::uint32_t>> found;
  for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
    const auto a = rviz_mesh_plugin::vectorOf(cornerOf(mesh, face, 0));
    const auto b = rviz_mesh_plugin::vectorOf(cornerOf(mesh, face, 1));
    const auto c = rviz_mesh_plugin::vectorOf(cornerOf(mesh, face, 2));
    const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    const double v = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
    const double w = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
    if (area != 0.0 && v >= -1e-9 && w >= -1e-9 && v + w <= 1.0 + 1e-9) {
      found.emplace_back(a[2] + v * (b[2] - a[2]) + w * (c[2] - a[2]), face);
    }
  }
  return found;
}

/// The point of a mesh at x and y whose z is nearest to this one.
inline SurfacePoint pointAt(const MeshData& mesh, double x, double y, double z = 0.0)
{
  SurfacePoint point;
  double least = 1e9;
  for (const auto& [height, face] : heightsAt(mesh, x, y)) {
    if (std::abs(height - z) < least) {
      least = std::abs(height - z);
      point = {face, {x, y, height}};
    }
  }
  if (least == 1e9) {
    throw std::runtime_error("the mesh has no such point");
  }
  return point;
}

}  // namespace measured_meshes
