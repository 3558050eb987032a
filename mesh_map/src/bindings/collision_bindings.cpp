// Solids of a mesh, and bodies that meet something, for Python (private).

#include "bindings/spatial_bindings.h"
#include "collision/collision.h"
#include "mesh/solids.h"

namespace mesh_map {
namespace {

py::array solidsOf(Array face_edges, Array face_flags, std::size_t edge_count)
{
  const auto edges = view<std::uint32_t>(face_edges, "face_edges", {face_flags.shape(0), 3});
  const auto flags = view<std::uint8_t>(face_flags, "face_flags", {ANY});
  return toArray(unlocked([&] { return findSolids(edges, flags, edge_count); }));
}

py::array collisionsOf(const Bvh& bvh, Array vertices, Array faces, Array offsets,
                       Array vertex_faces, Array solids, Array rooms, double radius,
                       double step_height, double robot_height, unsigned threads,
                       const CancelFlag* cancel)
{
  CollisionQuery query;
  query.mesh = meshView(vertices, faces);
  query.vertex_faces = rowsView(offsets, vertex_faces, query.mesh.faceCount(), "vertex_faces");
  query.solids = view<std::uint32_t>(solids, "solids", {faces.shape(0)});
  query.rooms = view<float>(rooms, "rooms", {vertices.shape(0)});
  query.radius = radius;
  query.step_height = step_height;
  query.robot_height = robot_height;
  return toArray(resultOf({threads, cancel}, query.mesh.faceCount(),
                          [&](const BvhOptions& run) { return collisions(bvh, query, run); }));
}

}  // namespace

void bindCollision(py::module_& module)
{
  module.def("_solids", &solidsOf);
  module.def("_collisions", &collisionsOf);
}

}  // namespace mesh_map
