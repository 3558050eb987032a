#include "rviz_mesh_plugin/validation.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "validation_findings.h"

namespace rviz_mesh_plugin {
namespace {

std::string coordinates(const char* name, std::size_t index, const geometry_msgs::Point& point)
{
  return text(name, " ", index, " is (", point.x, ", ", point.y, ", ", point.z, ")");
}

std::string channels(std::size_t index, const std_msgs::ColorRGBA& color)
{
  return text("the color of vertex ", index, " is (", color.r, ", ", color.g, ", ", color.b, ", ",
              color.a, ")");
}

void checkFaces(std::vector<Finding>& findings, const mesh_msgs::MeshGeometry& mesh)
{
  const std::size_t vertex_count = mesh.vertices.size();
  const auto bad_corner =
      [&](const mesh_msgs::MeshTriangleIndices& face) -> std::optional<std::uint32_t> {
    for (const std::uint32_t index : face.vertex_indices) {
      if (index >= vertex_count) {
        return index;
      }
    }
    return std::nullopt;
  };
  addFinding(
      findings, "face_index_out_of_range", mesh.faces,
      [&](const auto& face) { return bad_corner(face).has_value(); },
      [&](std::size_t first) {
        return text("face ", first, " refers to vertex ", *bad_corner(mesh.faces[first]),
                    ", but the mesh has ", vertex_count, " vertices");
      },
      "export the mesh again; indices count from 0");
}

}  // namespace

std::string Finding::sentence() const
{
  return text(what, count > 1 ? text(" (the first of ", count, ")") : "", hint.empty() ? "" : "; ",
              hint);
}

std::vector<Finding> check(const mesh_msgs::MeshGeometryStamped& message, const std::string& uuid)
{
  const auto& mesh = message.mesh_geometry;
  std::vector<Finding> findings;
  if (mesh.vertices.empty()) {
    findings.push_back({"no_vertices", "the mesh has no vertices", std::nullopt, 1,
                        "look at the node that publishes it: did it load its file?"});
  }
  if (mesh.faces.empty()) {
    findings.push_back({"no_faces",
                        text("the mesh has ", mesh.vertices.size(), " vertices, but no faces"),
                        std::nullopt, 1, "a point cloud has to be triangulated before"});
  }
  addFinding(
      findings, "vertex_not_finite", mesh.vertices,
      [](const auto& point) { return !isFinitePoint(point); },
      [&](std::size_t first) { return coordinates("vertex", first, mesh.vertices[first]); },
      "coordinates have to be finite as 32-bit floats");
  checkFaces(findings, mesh);
  if (!mesh.vertex_normals.empty() && mesh.vertex_normals.size() != mesh.vertices.size()) {
    findings.push_back({"normal_count",
                        text("there are ", mesh.vertex_normals.size(), " normals for ",
                             mesh.vertices.size(), " vertices"),
                        std::nullopt, 1, "send one normal per vertex, or none at all"});
  }
  addFinding(
      findings, "normal_not_finite", mesh.vertex_normals,
      [](const auto& normal) { return !isFinitePoint(normal); },
      [&](std::size_t first) { return coordinates("normal", first, mesh.vertex_normals[first]); },
      "send finite normals, or none at all: they are then computed");
  checkIdentity(findings, message, uuid);
  return findings;
}

std::vector<Finding> check(const mesh_msgs::MeshVertexCostsStamped& message,
                           std::optional<std::size_t> vertex_count, const std::string& uuid)
{
  const auto& costs = message.mesh_vertex_costs.costs;
  std::vector<Finding> findings;
  if (vertex_count) {
    if (auto finding = checkCostCount(costs.size(), *vertex_count)) {
      findings.push_back(std::move(*finding));
    }
  }
  checkCostValues(findings, costs, "vertex");
  checkIdentity(findings, message, uuid);
  return findings;
}

std::vector<Finding> check(const mesh_msgs::MeshFaceCostsStamped& message,
                           std::optional<std::size_t> face_count, const std::string& uuid)
{
  const auto& costs = message.mesh_face_costs.costs;
  std::vector<Finding> findings;
  if (face_count) {
    if (auto finding = checkFaceCostCount(costs.size(), *face_count)) {
      findings.push_back(std::move(*finding));
    }
  }
  checkCostValues(findings, costs, "face");
  checkIdentity(findings, message, uuid);
  return findings;
}

std::vector<Finding> check(const mesh_msgs::MeshVertexColorsStamped& message,
                           std::optional<std::size_t> vertex_count, const std::string& uuid)
{
  const auto& colors = message.mesh_vertex_colors.vertex_colors;
  const auto describe = [&](std::size_t first) { return channels(first, colors[first]); };
  std::vector<Finding> findings;
  if (vertex_count) {
    if (auto finding = checkColorCount(colors.size(), *vertex_count)) {
      findings.push_back(std::move(*finding));
    }
  }
  checkChannels(
      findings, colors, [](const auto& color) -> const auto& { return color; }, describe);
  checkIdentity(findings, message, uuid);
  return findings;
}

std::optional<Finding> checkCostCount(std::size_t cost_count, std::size_t vertex_count)
{
  if (cost_count == vertex_count) {
    return std::nullopt;
  }
  return Finding{"cost_count",
                 text("there are ", cost_count, " costs for ", vertex_count, " vertices"),
                 std::nullopt, 1, "compute the layer for this geometry"};
}

std::optional<Finding> checkFaceCostCount(std::size_t cost_count, std::size_t face_count)
{
  if (cost_count == face_count) {
    return std::nullopt;
  }
  return Finding{"cost_count", text("there are ", cost_count, " costs for ", face_count, " faces"),
                 std::nullopt, 1, "compute the layer for this geometry"};
}

std::optional<Finding> checkColorCount(std::size_t color_count, std::size_t vertex_count)
{
  if (color_count == vertex_count) {
    return std::nullopt;
  }
  return Finding{"color_count",
                 text("there are ", color_count, " colors for ", vertex_count, " vertices"),
                 std::nullopt, 1, "publish the colors of this geometry"};
}

std::string summarize(const std::vector<Finding>& findings)
{
  if (findings.empty()) {
    return std::string();
  }
  const std::size_t more = findings.size() - 1;
  return findings.front().sentence() + (more > 0 ? text(" (and ", more, " more findings)") : "");
}

}  // namespace rviz_mesh_plugin
