// mesh_map._kernels: the kernels of mesh_map_core for Python. Private: the public, typed classes
// are in the modules of mesh_map that import it. Arrays are checked here, once (ValueError), and
// the GIL is released while a kernel runs.

#include <mesh_map/closest_point.h>
#include <mesh_map/topology.h>

#include "array_checks.h"
#include "cancel_flag.h"
#include "dijkstra_bindings.h"
#include "front_bindings.h"
#include "geodesic_bindings.h"
#include "layer_bindings.h"
#include "query_bindings.h"
#include "spatial_bindings.h"
#include "trace_bindings.h"
#include "wave_front_bindings.h"

namespace mesh_map {
namespace {

using Array = const py::array&;

py::dict topology(Array faces, std::size_t vertex_count, unsigned threads)
{
  const auto face_view = view<std::uint32_t>(faces, "faces", {ANY, 3});
  Topology result;
  {
    const py::gil_scoped_release release;
    result = buildTopology(face_view, vertex_count, threads);
  }
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

py::array computeEdgeLengths(Array vertices, Array edges, unsigned threads)
{
  const auto positions = view<float>(vertices, "vertices", {ANY, 3});
  const auto edge_view = view<std::uint32_t>(edges, "edges", {ANY, 2});
  checkIndices(edge_view, static_cast<std::size_t>(vertices.shape(0)), "edges");
  std::vector<float> lengths;
  {
    const py::gil_scoped_release release;
    lengths = edgeLengths(positions, edge_view, threads);
  }
  return toArray(std::move(lengths));
}

py::tuple findClosestVertex(Array vertices, Array eligible, Array point, double max_distance)
{
  const auto positions = view<float>(vertices, "vertices", {ANY, 3});
  const auto eligible_view = view<std::uint8_t>(eligible, "eligible", {vertices.shape(0)});
  const auto query = view<double>(point, "point", {3});
  requireValue(max_distance >= 0.0, "the maximum distance has to be 0 or more");
  VertexHit hit;
  {
    const py::gil_scoped_release release;
    hit = closestVertex(positions, eligible_view, query.data(), max_distance);
  }
  return py::make_tuple(hit.vertex, hit.distance);
}

}  // namespace
}  // namespace mesh_map

PYBIND11_MODULE(_kernels, module)
{
  using namespace mesh_map;
  namespace py = pybind11;
  using py::arg;

  module.doc() = "Kernels of mesh_map_core. Private: use the modules of mesh_map.";
  module.attr("_NO_INDEX") = NO_INDEX;
  module.def("_topology", &topology, arg("faces"), arg("vertex_count"), arg("threads") = 0u);
  module.def("_edge_lengths", &computeEdgeLengths, arg("vertices"), arg("edges"),
             arg("threads") = 0u);
  module.def("_closest_vertex", &findClosestVertex, arg("vertices"), arg("eligible"), arg("point"),
             arg("max_distance"));
  py::class_<CancelFlag>(module, "_CancelFlag", py::module_local())
      .def(py::init<>())
      .def("_set", [](CancelFlag& self) { self.flag = true; })
      .def("_is_set", [](const CancelFlag& self) { return self.flag.load(); });
  bindDijkstra(module);
  bindFrontKernels(module);
  bindGeodesicKernels(module);
  bindLayerKernels(module);
  bindQueryKernels(module);
  bindSpatial(module);
  bindTraceKernels(module);
  bindWaveFront(module);
}
