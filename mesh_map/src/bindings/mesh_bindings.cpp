// Topology, normals, orientation and statistics of neighborhoods for Python (private).

#include <mesh_map/mesh/topology.h>

#include <pybind11/stl.h>

#include <array>
#include <string>

#include "bindings/bindings.h"
#include "mesh/normals.h"
#include "mesh/orientation.h"
#include "mesh/radius_statistics.h"

namespace mesh_map {
namespace {

py::dict topology(Array faces, std::size_t vertex_count, unsigned threads)
{
  const auto face_view = view<std::uint32_t>(faces, "faces", {ANY, 3});
  Topology result = unlocked([&] { return buildTopology(face_view, vertex_count, threads); });
  py::dict arrays;
  arrays["component_count"] = result.component_count;
  arrays["edges"] = toRows(std::move(result.edges), 2);
  arrays["face_edges"] = toRows(std::move(result.face_edges), 3);
  arrays["edge_face_counts"] = toArray(std::move(result.edge_face_counts));
  arrays["edge_flags"] = toArray(std::move(result.edge_flags));
  arrays["face_flags"] = toArray(std::move(result.face_flags));
  arrays["vertex_flags"] = toArray(std::move(result.vertex_flags));
  arrays["neighbor_offsets"] = toArray(std::move(result.neighbor_offsets));
  arrays["neighbors"] = toArray(std::move(result.neighbors));
  arrays["neighbor_edges"] = toArray(std::move(result.neighbor_edges));
  arrays["vertex_face_offsets"] = toArray(std::move(result.vertex_face_offsets));
  arrays["vertex_faces"] = toArray(std::move(result.vertex_faces));
  arrays["components"] = toArray(std::move(result.components));
  return arrays;
}

py::array computeEdgeLengths(Array vertices, Array edges)
{
  const auto positions = view<float>(vertices, "vertices", {ANY, 3});
  const auto edge_view = view<std::uint32_t>(edges, "edges", {ANY, 2});
  checkIndices(edge_view, static_cast<std::size_t>(vertices.shape(0)), "edges");
  return toArray(unlocked([&] { return edgeLengths(positions, edge_view); }));
}

py::tuple edgeRows(Array face_edges, std::size_t edge_count)
{
  const auto edges = view<std::uint32_t>(face_edges, "face_edges", {ANY, 3});
  EdgeFaces rows = unlocked([&] { return edgeFaces(edges, edge_count); });
  return toArrays(std::move(rows.offsets), std::move(rows.faces));
}

py::tuple computeFaceNormals(Array vertices, Array faces, const std::array<float, 3>& fallback)
{
  const MeshView mesh = meshView(vertices, faces);
  FaceNormals result = unlocked([&] { return faceNormals(mesh, fallback); });
  return py::make_tuple(toRows(std::move(result.normals), 3),
                        toArray(std::move(result.without_area)));
}

py::array computeCornerAngles(Array vertices, Array faces)
{
  const MeshView mesh = meshView(vertices, faces);
  return toRows(unlocked([&] { return cornerAngles(mesh); }), 3);
}

py::array computeVertexNormals(Array face_normals, Array offsets, Array vertex_faces, Array ignored,
                               const py::object& faces, const py::object& corner_angles,
                               const std::array<float, 3>& fallback)
{
  VertexNormalsInput input;
  input.face_normals = view<float>(face_normals, "face_normals", {ANY, 3});
  const py::ssize_t face_count = face_normals.shape(0);
  input.ignored = view<std::uint8_t>(ignored, "ignored", {face_count});
  input.vertex_faces =
      rowsView(offsets, vertex_faces, static_cast<std::size_t>(face_count), "vertex_faces");
  if (!corner_angles.is_none()) {
    input.faces = view<std::uint32_t>(py::cast<py::array>(faces), "faces", {face_count, 3});
    input.corner_angles =
        view<float>(py::cast<py::array>(corner_angles), "corner_angles", {face_count, 3});
  }
  input.fallback = fallback;
  return toRows(unlocked([&] { return vertexNormals(input); }), 3);
}

py::tuple computeOrientation(Array vertices, Array faces, Array face_edges, Array edge_face_counts,
                             Array edge_flags, Array up)
{
  const MeshView mesh = meshView(vertices, faces);
  const auto face_count = static_cast<py::ssize_t>(mesh.faceCount());
  const auto sides = view<std::uint32_t>(face_edges, "face_edges", {face_count, 3});
  const auto counts = view<std::uint32_t>(edge_face_counts, "edge_face_counts", {ANY});
  const auto flags = view<std::uint8_t>(edge_flags, "edge_flags", {edge_face_counts.shape(0)});
  const auto to = triple<double>(up, "up");
  Orientation result = unlocked([&] { return orientFaces(mesh, sides, counts, flags, to); });
  return py::make_tuple(toArray(std::move(result.turned)), result.patch_count, result.conflicts,
                        toArray(std::move(result.patches)));
}

py::tuple computeRadiusStatistics(Array vertices, Array offsets, Array neighbors, Array faces,
                                  Array face_offsets, Array vertex_faces, Array angles,
                                  Array normals, Array up, double radius, unsigned wanted,
                                  const std::string& search)
{
  const py::ssize_t rows = vertices.ndim() == 2 ? vertices.shape(0) : 0;
  const auto vertex_count = static_cast<std::size_t>(rows);
  RadiusQuery query;
  query.positions = view<float>(vertices, "vertices", {ANY, 3});
  query.neighbors = rowsView(offsets, neighbors, vertex_count, "neighbors");
  requireValue(query.neighbors.rowCount() == vertex_count, "offsets need one row per vertex");
  if (wanted & (SURFACE_HEIGHT_DIFFERENCE | SURFACE_HEIGHT_DIFFERENCE_AROUND)) {
    const MeshView mesh = meshView(vertices, faces);
    query.faces = mesh.faces;
    query.vertex_faces = rowsView(face_offsets, vertex_faces, mesh.faceCount(), "vertex_faces");
    requireValue(query.vertex_faces.rowCount() == vertex_count,
                 "vertex_faces need one row per vertex");
  }
  query.angles =
      view<float>(angles, "angles", {wanted & (ROUGHNESS | ROUGHNESS_AROUND) ? rows : ANY});
  query.normals = view<float>(normals, "normals", {wanted & RIDGE ? rows : ANY, 3});
  query.up = triple<double>(up, "up");
  requireValue(radius > 0.0, "the radius has to be above 0");
  query.radius = radius;
  query.wanted = wanted;
  query.search = choiceOf<RadiusSearch>(search, {"automatic", "edges", "grid"}, "search");
  RadiusStatistics result = unlocked([&] { return radiusStatistics(query); });
  return toArrays(std::move(result.height_differences), std::move(result.roughnesses),
                  std::move(result.ridges), std::move(result.height_differences_around),
                  std::move(result.roughnesses_around),
                  std::move(result.surface_height_differences),
                  std::move(result.surface_height_differences_around));
}

py::array computeMeanEdgeAngles(Array normals, Array edges, Array offsets, Array neighbor_edges)
{
  const auto normal_view = view<float>(normals, "normals", {ANY, 3});
  const auto edge_view = view<std::uint32_t>(edges, "edges", {ANY, 2});
  checkIndices(edge_view, static_cast<std::size_t>(normals.shape(0)), "edges");
  const RowsView rows = rowsView(offsets, neighbor_edges, edge_view.size() / 2, "neighbor_edges");
  requireValue(rows.rowCount() == normal_view.size() / 3, "offsets need one row per vertex");
  return toArray(unlocked([&] { return meanEdgeAngles(normal_view, edge_view, rows); }));
}

py::array computeAnglesTo(Array normals, Array up)
{
  const auto normal_view = view<float>(normals, "normals", {ANY, 3});
  const auto to = triple<double>(up, "direction");
  return toArray(unlocked([&] { return anglesTo(normal_view, to); }));
}

}  // namespace

void bindMesh(py::module_& module)
{
  module.def("_topology", &topology);
  module.def("_edge_lengths", &computeEdgeLengths);
  module.def("_edge_faces", &edgeRows);
  module.def("_face_normals", &computeFaceNormals);
  module.def("_corner_angles", &computeCornerAngles);
  module.def("_vertex_normals", &computeVertexNormals);
  module.def("_orientation", &computeOrientation);
  module.def("_radius_statistics", &computeRadiusStatistics);
  module.def("_mean_edge_angles", &computeMeanEdgeAngles);
  module.def("_angles_to", &computeAnglesTo);
}

}  // namespace mesh_map
