#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>

/// Messages for tests, all in frame "map" and with uuid "mesh" unless changed.
namespace test_meshes {

inline geometry_msgs::Point point(double x, double y, double z)
{
  geometry_msgs::Point p;
  p.x = x;
  p.y = y;
  p.z = z;
  return p;
}

inline void addFace(mesh_msgs::MeshGeometryStamped& message, std::uint32_t a, std::uint32_t b,
                    std::uint32_t c)
{
  mesh_msgs::MeshTriangleIndices face;
  face.vertex_indices = {a, b, c};
  message.mesh_geometry.faces.push_back(face);
}

inline mesh_msgs::MeshGeometryStamped emptyMesh(const std::string& uuid = "mesh")
{
  mesh_msgs::MeshGeometryStamped message;
  message.header.frame_id = "map";
  message.uuid = uuid;
  return message;
}

/// @a cells x @a cells squares of two faces over [-1, 1]², row by row, counter-clockwise from
/// above; height(x, y).
template <class Height>
mesh_msgs::MeshGeometryStamped terrain(std::uint32_t cells, const Height& height)
{
  auto message = emptyMesh();
  for (std::uint32_t row = 0; row <= cells; ++row) {
    for (std::uint32_t column = 0; column <= cells; ++column) {
      const double x = -1.0 + 2.0 * column / cells;
      const double y = -1.0 + 2.0 * row / cells;
      message.mesh_geometry.vertices.push_back(point(x, y, height(x, y)));
    }
  }
  for (std::uint32_t row = 0; row < cells; ++row) {
    for (std::uint32_t column = 0; column < cells; ++column) {
      const std::uint32_t corner = row * (cells + 1) + column;
      addFace(message, corner, corner + 1, corner + cells + 2);
      addFace(message, corner, corner + cells + 2, corner + cells + 1);
    }
  }
  return message;
}

/// The square [-1, 1]² at a height; its vertices, row by row: (-1,-1), (1,-1), (-1,1), (1,1).
inline mesh_msgs::MeshGeometryStamped square(double z = 0.0)
{
  return terrain(1, [z](double, double) { return z; });
}

/// Turns all faces round.
inline mesh_msgs::MeshGeometryStamped flipped(mesh_msgs::MeshGeometryStamped message)
{
  for (auto& face : message.mesh_geometry.faces) {
    std::swap(face.vertex_indices[1], face.vertex_indices[2]);
  }
  return message;
}

inline mesh_msgs::MeshVertexCostsStamped costs(const std::string& type,
                                               const std::vector<float>& values,
                                               const std::string& uuid = "mesh")
{
  mesh_msgs::MeshVertexCostsStamped message;
  message.header.frame_id = "map";
  message.uuid = uuid;
  message.type = type;
  message.mesh_vertex_costs.costs = values;
  return message;
}

inline std_msgs::ColorRGBA color(float r, float g, float b, float a = 1.0f)
{
  std_msgs::ColorRGBA c;
  c.r = r;
  c.g = g;
  c.b = b;
  c.a = a;
  return c;
}

inline mesh_msgs::MeshVertexColorsStamped colors(const std::vector<std_msgs::ColorRGBA>& values,
                                                 const std::string& uuid = "mesh")
{
  mesh_msgs::MeshVertexColorsStamped message;
  message.header.frame_id = "map";
  message.uuid = uuid;
  message.mesh_vertex_colors.vertex_colors = values;
  return message;
}

}  // namespace test_meshes
