// Holes, manifolds and simplification for Python (private).

#include <string>

#include "bindings/bindings.h"
#include "mesh/repair/border_loops.h"
#include "mesh/repair/hole_filling.h"
#include "mesh/repair/manifold.h"
#include "mesh/repair/simplification.h"

namespace mesh_map {
namespace {

py::tuple findBorderLoops(Array faces, std::size_t vertex_count)
{
  const auto face_view = view<std::uint32_t>(faces, "faces", {ANY, 3});
  BorderLoops loops =
      unlocked([&] { return borderLoops(face_view, buildTopology(face_view, vertex_count)); });
  return py::make_tuple(toArray(std::move(loops.offsets)), toArray(std::move(loops.vertices)),
                        toArray(std::move(loops.faces)), loops.open_edges);
}

py::dict computeManifold(Array vertices, Array faces)
{
  const MeshView mesh = meshView(vertices, faces);
  ManifoldMesh made = unlocked([&] { return makeManifold(mesh); });
  py::dict result;
  result["faces"] = toRows(std::move(made.faces), 3);
  result["face_parents"] = toArray(std::move(made.face_parents));
  result["vertex_parents"] = toRows(std::move(made.vertex_parents), 2);
  result["degenerate_faces"] = made.degenerate_faces;
  result["duplicate_faces"] = made.duplicate_faces;
  result["split_vertices"] = made.split_vertices;
  result["split_edges"] = made.split_edges;
  return result;
}

py::dict computeHoleFilling(Array vertices, Array faces, double perimeter, double flatness,
                            double slope, double fold, bool keep_outer, bool refine, Array up,
                            std::size_t face_limit)
{
  const MeshView mesh = meshView(vertices, faces);
  HoleLimits limits;
  limits.perimeter = perimeter;
  limits.flatness = flatness;
  limits.slope = slope;
  limits.fold = fold;
  limits.keep_outer = keep_outer;
  limits.refine = refine;
  limits.up = triple<double>(up, "up");
  limits.face_limit = face_limit;
  HoleFilling found = unlocked([&] { return fillHoles(mesh, limits); });
  py::dict result;
  result["offsets"] = toArray(std::move(found.loops.offsets));
  result["open_edges"] = found.loops.open_edges;
  result["fates"] = toArray(std::move(found.fates));
  result["perimeters"] = toArray(std::move(found.perimeters));
  result["deviations"] = toArray(std::move(found.deviations));
  result["points"] = toRows(std::move(found.points), 3);
  result["vertex_parents"] = toRows(std::move(found.vertex_parents), 3);
  result["vertex_weights"] = toRows(std::move(found.vertex_weights), 3);
  result["faces"] = toRows(std::move(found.faces), 3);
  result["face_parents"] = toArray(std::move(found.face_parents));
  result["face_loops"] = toArray(std::move(found.face_loops));
  return result;
}

py::tuple computeSimplification(Array vertices, Array faces, Array regions, Array frozen,
                                std::size_t target, double max_error)
{
  const MeshView mesh = meshView(vertices, faces);
  const auto region_view = view<std::uint32_t>(regions, "regions", {ANY});
  const auto frozen_view = view<std::uint8_t>(frozen, "frozen", {ANY});
  SimplifiedFaces found =
      unlocked([&] { return simplifyFaces(mesh, region_view, frozen_view, target, max_error); });
  return py::make_tuple(toRows(std::move(found.faces), 3), toArray(std::move(found.regions)),
                        found.error);
}

}  // namespace

void bindRepair(py::module_& module)
{
  module.attr("_CAN_SIMPLIFY") = canSimplify();
  module.def("_border_loops", &findBorderLoops);
  module.def("_manifold", &computeManifold);
  module.def("_hole_filling", &computeHoleFilling);
  module.def("_simplification", &computeSimplification);
}

}  // namespace mesh_map
