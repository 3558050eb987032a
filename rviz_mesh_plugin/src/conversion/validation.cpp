#include "conversion/validation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include <std_msgs/ColorRGBA.h>

#include "base/status_lines.h"
#include "labels/label_name.h"

namespace rviz_mesh_plugin {
namespace {

void addFinding(std::vector<Finding>& findings, const std::optional<Finding>& finding)
{
  if (finding) {
    findings.push_back(*finding);
  }
}

/// There have to be as many @a things as @a others.
std::optional<Finding> checkCount(const char* rule, std::size_t count, const char* things,
                                  std::size_t wanted, const char* others, const char* hint)
{
  if (count == wanted) {
    return std::nullopt;
  }
  return Finding{rule, joined("there are ", count, " ", things, " for ", wanted, " ", others),
                 hint};
}

/// Finite as a float, which is what OGRE computes with: 1e60 is finite as a double only.
bool isFinite(double value)
{
  return std::isfinite(static_cast<float>(value));
}

template <class Function>
bool anyChannel(const std_msgs::ColorRGBA& color, const Function& function)
{
  return function(color.r) || function(color.g) || function(color.b) || function(color.a);
}

/// Counts the elements for which @a is_bad holds and adds one finding for them; @a describe is
/// given the first.
template <class Elements, class IsBad, class Describe>
void addFinding(std::vector<Finding>& findings, const char* rule, const Elements& elements,
                const IsBad& is_bad, const Describe& describe, const char* hint)
{
  std::size_t first = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (is_bad(elements[i])) {
      first = count == 0 ? i : first;
      ++count;
    }
  }
  if (count > 0) {
    findings.push_back({rule, describe(first), hint, count});
  }
}

/// Text of a message in quotes, on one line and not too long for a status line.
std::string shown(const std::string& text)
{
  return "'" + shortened(text, 60, '?') + "'";
}

void checkUuid(std::vector<Finding>& findings, const std::string& given,
               const std::string& expected)
{
  if (!expected.empty() && given != expected) {
    findings.push_back(
        Finding{"uuid_mismatch",
                joined("the uuid is ", shown(given), ", but ", shown(expected), " is expected"),
                "publish it with the uuid of the geometry it belongs to"});
  }
}

template <class Message>
void checkIdentity(std::vector<Finding>& findings, const Message& message, const std::string& uuid)
{
  checkUuid(findings, message.uuid, uuid);
  if (message.header.frame_id.empty()) {
    findings.push_back(Finding{"frame_id_empty", "header.frame_id is empty",
                               "set it to the frame of the coordinates"});
  }
}

/// Color channels are numbers from 0 to 1.
/// @param noun what has the color that @a color_of gives
template <class Colors, class ColorOf>
void checkChannels(std::vector<Finding>& findings, const Colors& colors, const char* noun,
                   const ColorOf& color_of)
{
  const auto describe = [&](std::size_t first) {
    const std_msgs::ColorRGBA& color = color_of(colors[first]);
    return joined("the color of ", noun, " ", first, " is (", color.r, ", ", color.g, ", ", color.b,
                  ", ", color.a, ")");
  };
  addFinding(
      findings, "color_not_finite", colors,
      [&](const auto& element) {
        return anyChannel(color_of(element), [](float c) { return !std::isfinite(c); });
      },
      describe, "color channels are numbers from 0 to 1");
  addFinding(
      findings, "color_out_of_range", colors,
      [&](const auto& element) {
        return anyChannel(color_of(element),
                          [](float c) { return std::isfinite(c) && (c < 0.0f || c > 1.0f); });
      },
      describe, "color channels run from 0 to 1: divide by 255?");
}

/// @param noun what has the costs, e.g. "vertex"
void checkCostValues(std::vector<Finding>& findings, const std::vector<float>& costs,
                     const char* noun)
{
  addFinding(
      findings, "cost_negative_infinity", costs,
      [](float cost) { return std::isinf(cost) && cost < 0.0f; },
      [&](std::size_t first) { return joined("the cost of ", noun, " ", first, " is -inf"); },
      "lethal is +inf, unknown is NaN");
}

/// @param noun what the points are
void checkPoints(std::vector<Finding>& findings, const char* rule, const char* noun,
                 const std::vector<geometry_msgs::Point>& points, const char* hint)
{
  addFinding(
      findings, rule, points,
      [](const auto& point) {
        return !isFinite(point.x) || !isFinite(point.y) || !isFinite(point.z);
      },
      [&](std::size_t first) {
        const geometry_msgs::Point& point = points[first];
        return joined(noun, " ", first, " is (", point.x, ", ", point.y, ", ", point.z, ")");
      },
      hint);
}

void checkFaces(std::vector<Finding>& findings, const mesh_msgs::MeshGeometry& mesh)
{
  const std::size_t vertex_count = mesh.vertices.size();
  const auto bad_corner = [&](const mesh_msgs::MeshTriangleIndices& face) {
    return std::find_if(face.vertex_indices.begin(), face.vertex_indices.end(),
                        [&](std::uint32_t index) { return index >= vertex_count; });
  };
  addFinding(
      findings, "face_index_out_of_range", mesh.faces,
      [&](const auto& face) { return bad_corner(face) != face.vertex_indices.end(); },
      [&](std::size_t first) {
        return joined("face ", first, " refers to vertex ", *bad_corner(mesh.faces[first]),
                      ", but the mesh has ", vertex_count, " vertices");
      },
      "export the mesh again; indices count from 0");
}

/// @a noun is what refers to an index of the mesh, @a target what it refers to.
void checkIndices(std::vector<Finding>& findings, const char* rule, const std::string& noun,
                  const char* target, const std::vector<std::uint32_t>& indices,
                  std::optional<std::size_t> limit, const char* hint)
{
  if (limit) {
    addFinding(
        findings, rule, indices, [&](std::uint32_t index) { return index >= *limit; },
        [&](std::size_t first) {
          return joined(noun, " ", first, " refers to ", target, " ", indices[first],
                        ", but there are ", *limit);
        },
        hint);
  }
}

void checkCluster(std::vector<Finding>& findings, const mesh_msgs::MeshFaceCluster& cluster,
                  std::optional<std::size_t> face_count, const std::string& prefix)
{
  checkIndices(findings, "cluster_face_out_of_range", prefix + "entry", "face",
               cluster.face_indices, face_count, "name faces of the mesh that the uuid stands for");
  const std::string fault = labelFault(cluster.label);
  if (!fault.empty()) {
    findings.push_back(Finding{"label_unusable",
                               joined(prefix, "the label ", shown(cluster.label), " ", fault),
                               "choose up to 255 bytes without '/', such as 'tree_1'"});
  }
}

std::optional<Finding> checkCoordinateCount(std::size_t count, std::size_t vertex_count)
{
  return checkCount("texture_coordinate_count", count, "texture coordinates",
                    count == 0 ? 0 : vertex_count, "vertices",
                    "send a pair for each vertex, or none at all");
}

void checkCoordinates(std::vector<Finding>& findings,
                      const std::vector<mesh_msgs::MeshVertexTexCoords>& coordinates,
                      std::optional<std::size_t> vertex_count)
{
  if (vertex_count) {
    addFinding(findings, checkCoordinateCount(coordinates.size(), *vertex_count));
  }
  addFinding(
      findings, "texture_coordinate_not_finite", coordinates,
      [](const auto& pair) { return !isFinite(pair.u) || !isFinite(pair.v); },
      [&](std::size_t first) {
        return joined("texture coordinate ", first, " is (", coordinates[first].u, ", ",
                      coordinates[first].v, ")");
      },
      "send 0 where there is no texture");
}

constexpr std::array<PixelEncoding, 12> ENCODINGS{{{"rgb8", 1, 3, 0, 1, 2, -1},
                                                   {"bgr8", 1, 3, 2, 1, 0, -1},
                                                   {"rgba8", 1, 4, 0, 1, 2, 3},
                                                   {"bgra8", 1, 4, 2, 1, 0, 3},
                                                   {"mono8", 1, 1, 0, 0, 0, -1},
                                                   {"8UC1", 1, 1, 0, 0, 0, -1},
                                                   {"8UC3", 1, 3, 0, 1, 2, -1},
                                                   {"8UC4", 1, 4, 0, 1, 2, 3},
                                                   {"mono16", 2, 1, 0, 0, 0, -1},
                                                   {"16UC1", 2, 1, 0, 0, 0, -1},
                                                   {"rgb16", 2, 3, 0, 1, 2, -1},
                                                   {"rgba16", 2, 4, 0, 1, 2, 3}}};

std::optional<Finding> checkImage(const sensor_msgs::Image& image)
{
  const PixelEncoding* const encoding = findEncoding(image.encoding);
  if (!encoding) {
    std::string names;
    for (const PixelEncoding& known : ENCODINGS) {
      names += joined(names.empty() ? "" : ", ", known.name);
    }
    return Finding{"image_encoding", joined("the texture has the encoding ", shown(image.encoding)),
                   joined("use one of ", names)};
  }
  if (image.width == 0 || image.height == 0) {
    return Finding{"image_empty",
                   joined("the texture has ", image.width, " x ", image.height, " pixels"),
                   "leave the texture out"};
  }
  // All 32-bit numbers, and at most 8 bytes: nothing overflows in 64 bits.
  const std::uint64_t row = image.width * std::uint64_t{encoding->bytes()};
  if (image.step >= row && image.data.size() >= std::uint64_t(image.step) * image.height) {
    return std::nullopt;
  }
  return Finding{
      "image_size",
      joined("a texture of ", image.width, " x ", image.height, " pixels in ", image.encoding,
             " has a step of ", image.step, " and ", image.data.size(), " bytes"),
      joined("send ", row, " bytes for each row")};
}

/// Costs of all vertices or faces.
template <class Message>
std::vector<Finding> checkCosts(const Message& message, const std::vector<float>& costs,
                                bool on_faces, std::optional<std::size_t> count,
                                const std::string& uuid)
{
  std::vector<Finding> findings;
  addFinding(findings, checkCostCount(costs.size(), count.value_or(costs.size()), on_faces));
  checkCostValues(findings, costs, on_faces ? "face" : "vertex");
  checkIdentity(findings, message, uuid);
  return findings;
}

}  // namespace

std::string Finding::sentence() const
{
  return joined(what, count > 1 ? joined(" (the first of ", count, ")") : "",
                hint.empty() ? "" : "; ", hint);
}

const PixelEncoding* findEncoding(const std::string& name)
{
  const auto found = std::find_if(ENCODINGS.begin(), ENCODINGS.end(),
                                  [&](const PixelEncoding& known) { return name == known.name; });
  return found == ENCODINGS.end() ? nullptr : &*found;
}

std::vector<Finding> check(const mesh_msgs::MeshGeometryStamped& message, const std::string& uuid)
{
  const auto& mesh = message.mesh_geometry;
  std::vector<Finding> findings;
  if (mesh.vertices.empty()) {
    findings.push_back(Finding{"no_vertices", "the mesh has no vertices",
                               "look at the node that publishes it: did it load its file?"});
  }
  if (mesh.faces.empty()) {
    findings.push_back(Finding{
        "no_faces", joined("the mesh has ", mesh.vertices.size(), " vertices, but no faces"),
        "a point cloud has to be triangulated before"});
  }
  checkPoints(findings, "vertex_not_finite", "vertex", mesh.vertices,
              "coordinates have to be finite as 32-bit floats");
  checkFaces(findings, mesh);
  if (!mesh.vertex_normals.empty()) {
    addFinding(findings, checkCount("normal_count", mesh.vertex_normals.size(), "normals",
                                    mesh.vertices.size(), "vertices",
                                    "send one normal per vertex, or none at all"));
  }
  checkPoints(findings, "normal_not_finite", "normal", mesh.vertex_normals,
              "send finite normals, or none at all: they are then computed");
  checkIdentity(findings, message, uuid);
  return findings;
}

std::vector<Finding> check(const mesh_msgs::MeshVertexCostsStamped& message,
                           std::optional<std::size_t> vertex_count, const std::string& uuid)
{
  return checkCosts(message, message.mesh_vertex_costs.costs, false, vertex_count, uuid);
}

std::vector<Finding> check(const mesh_msgs::MeshFaceCostsStamped& message,
                           std::optional<std::size_t> face_count, const std::string& uuid)
{
  return checkCosts(message, message.mesh_face_costs.costs, true, face_count, uuid);
}

std::vector<Finding> check(const mesh_msgs::MeshVertexColorsStamped& message,
                           std::optional<std::size_t> vertex_count, const std::string& uuid)
{
  const auto& colors = message.mesh_vertex_colors.vertex_colors;
  std::vector<Finding> findings;
  addFinding(findings, checkColorCount(colors.size(), vertex_count.value_or(colors.size())));
  checkChannels(
      findings, colors, "vertex", [](const auto& color) -> const auto& { return color; });
  checkIdentity(findings, message, uuid);
  return findings;
}

std::vector<Finding> check(const mesh_msgs::MeshVertexCostsSparseStamped& message,
                           std::optional<std::size_t> vertex_count, const std::string& uuid)
{
  const auto& sparse = message.mesh_vertex_costs;
  std::vector<Finding> findings;
  addFinding(findings,
             checkCount("cost_count", sparse.costs.size(), "costs", sparse.vertices.size(),
                        "vertices", "send a cost for each of the vertices"));
  checkCostValues(findings, sparse.costs, "entry");
  if (std::isinf(sparse.default_value) && sparse.default_value < 0.0f) {
    findings.push_back(Finding{"cost_negative_infinity", "default_value is -inf",
                               "lethal is +inf, unknown is NaN"});
  }
  checkIndices(findings, "vertex_index_out_of_range", "entry", "vertex", sparse.vertices,
               vertex_count, "name vertices of the mesh that the uuid stands for");
  checkIdentity(findings, message, uuid);
  return findings;
}

std::vector<Finding> check(const mesh_msgs::MeshFaceCluster& message,
                           std::optional<std::size_t> face_count)
{
  std::vector<Finding> findings;
  checkCluster(findings, message, face_count, "");
  return findings;
}

std::vector<Finding> check(const mesh_msgs::MeshMaterialsStamped& message,
                           std::optional<std::size_t> vertex_count,
                           std::optional<std::size_t> face_count, const std::string& uuid)
{
  const auto& given = message.mesh_materials;
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < given.clusters.size(); ++i) {
    checkCluster(findings, given.clusters[i], face_count, joined("cluster ", i, ": "));
  }
  addFinding(findings, checkCount("cluster_material_count", given.cluster_materials.size(),
                                  "cluster_materials", given.clusters.size(), "clusters",
                                  "send the index of a material for each cluster"));
  checkIndices(findings, "material_index_out_of_range", "cluster", "material",
               given.cluster_materials, given.materials.size(), "send the index of a material");
  checkChannels(
      findings, given.materials, "material",
      [](const auto& material) -> const auto& { return material.color; });
  checkCoordinates(findings, given.vertex_tex_coords, vertex_count);
  checkIdentity(findings, message, uuid);
  return findings;
}

std::vector<Finding> check(const mesh_msgs::MeshTexture& message, const std::string& uuid)
{
  std::vector<Finding> findings;
  addFinding(findings, checkImage(message.image));
  checkUuid(findings, message.uuid, uuid);
  return findings;
}

std::optional<Finding> checkCostCount(std::size_t cost_count, std::size_t count, bool on_faces)
{
  return checkCount("cost_count", cost_count, "costs", count, on_faces ? "faces" : "vertices",
                    "compute the layer for this geometry");
}

std::optional<Finding> checkColorCount(std::size_t color_count, std::size_t vertex_count)
{
  return checkCount("color_count", color_count, "colors", vertex_count, "vertices",
                    "publish the colors of this geometry");
}

std::optional<Finding> checkUpdateFits(const CostUpdate& update, std::size_t vertex_count)
{
  std::vector<Finding> findings;
  checkIndices(findings, "vertex_index_out_of_range", "entry", "vertex", update.vertices,
               vertex_count, "publish the update for this geometry");
  return findings.empty() ? std::nullopt : std::make_optional(findings.front());
}

std::optional<Finding> checkMaterialsFit(const Materials& materials, std::size_t vertex_count,
                                         std::size_t face_count)
{
  if (!materials.faces.empty() && materials.faces.back() >= face_count) {
    const auto first = std::lower_bound(materials.faces.begin(), materials.faces.end(), face_count);
    return Finding{
        "cluster_face_out_of_range",
        joined("the materials refer to face ", *first, ", but the mesh has ", face_count, " faces"),
        "publish the materials of this geometry",
        static_cast<std::size_t>(materials.faces.end() - first)};
  }
  return checkCoordinateCount(materials.texture_coordinates.size(), vertex_count);
}

std::string summarize(const std::vector<Finding>& findings)
{
  if (findings.empty()) {
    return std::string();
  }
  const std::size_t more = findings.size() - 1;
  return findings.front().sentence() + (more > 0 ? joined(" (and ", more, " more findings)") : "");
}

}  // namespace rviz_mesh_plugin
