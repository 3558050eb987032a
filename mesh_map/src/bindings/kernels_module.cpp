// mesh_map._kernels: the kernels of mesh_map_core for Python. Private: the public, typed classes
// are in the modules of mesh_map that import it. Arrays are checked here, once (ValueError), and
// the GIL is released while a kernel runs.

#include <mesh_map/base/parallel.h>
#include <mesh_map/bvh/closest/bvh_closest.h>

#include <optional>

#include "bindings/bindings.h"

namespace mesh_map {
namespace {

py::tuple findClosestVertex(Array vertices, Array eligible, Array point, double max_distance)
{
  const auto positions = view<float>(vertices, "vertices", {ANY, 3});
  const auto eligible_view = view<std::uint8_t>(eligible, "eligible", {vertices.shape(0)});
  const auto query = triple<double>(point, "point");
  requireValue(max_distance >= 0.0, "the maximum distance has to be 0 or more");
  const VertexHit hit =
      unlocked([&] { return closestVertex(positions, eligible_view, query.data(), max_distance); });
  return py::make_tuple(hit.vertex, hit.distance);
}

/// A `with` block of Python, for the thread that enters it.
struct BackgroundBlock
{
  std::optional<BackgroundLoops> loops;
};

}  // namespace
}  // namespace mesh_map

PYBIND11_MODULE(_kernels, module)
{
  using namespace mesh_map;
  namespace py = pybind11;
  module.doc() = "Kernels of mesh_map_core. Private: use the modules of mesh_map.";
  module.attr("_NO_INDEX") = NO_INDEX;
  module.def("_closest_vertex", &findClosestVertex);
  py::class_<CancelFlag>(module, "_CancelFlag", py::module_local())
      .def(py::init<>())
      .def("_set", [](CancelFlag& self) { self.flag = true; })
      .def("_is_set", [](const CancelFlag& self) { return self.flag.load(); });
  py::class_<BackgroundBlock>(module, "_BackgroundLoops", py::module_local())
      .def(py::init<>())
      .def("__enter__", [](BackgroundBlock& self) { self.loops.emplace(); })
      .def("__exit__", [](BackgroundBlock& self, const py::args&) { self.loops.reset(); });
  bindMesh(module);
  bindRepair(module);
  bindSpatial(module);
  bindCollision(module);
  bindDijkstra(module);
  bindObstacleDistance(module);
  bindFastMarching(module);
  bindQueryKernels(module);
  bindTraceKernels(module);
  bindReconstruction(module);
  bindSignals(module);
}
