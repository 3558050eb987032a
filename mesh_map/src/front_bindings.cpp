#include "front_bindings.h"

#include <mesh_map/front_mesh.h>
#include <mesh_map/inflation.h>

#include <memory>
#include <string>

#include "array_checks.h"
#include "cancel_flag.h"

namespace mesh_map {
namespace {

using Array = const py::array&;

std::shared_ptr<FrontMesh> makeMesh(Array vertices, Array faces, Array offsets, Array vertex_faces,
                                    unsigned threads)
{
  const MeshView mesh = meshView(vertices, faces);
  const RowsView rows = rowsView(offsets, vertex_faces, mesh.faceCount(), "vertex_faces");
  const py::gil_scoped_release release;
  return std::make_shared<FrontMesh>(mesh, rows, threads);
}

const std::atomic<bool>* flagOf(const CancelFlag* cancel)
{
  return cancel == nullptr ? nullptr : &cancel->flag;
}

ArrayView<std::uint8_t> lethalView(const ObstacleDistance& self, Array lethal)
{
  const auto count = static_cast<py::ssize_t>(self.mesh().vertexCount());
  return view<std::uint8_t>(lethal, "lethal", {count});
}

bool computeObstacles(ObstacleDistance& self, Array lethal, const CancelFlag* cancel,
                      unsigned threads)
{
  const ArrayView<std::uint8_t> flags = lethalView(self, lethal);
  const py::gil_scoped_release release;
  return self.compute(flags, flagOf(cancel), threads);
}

py::array updateObstacles(ObstacleDistance& self, Array lethal)
{
  const ArrayView<std::uint8_t> flags = lethalView(self, lethal);
  std::vector<std::uint32_t> changed;
  {
    const py::gil_scoped_release release;
    changed = self.update(flags);
  }
  return toArray(std::move(changed));
}

py::array obstacleDistances(const ObstacleDistance& self)
{
  return toArray(std::vector<float>(self.distances().begin(), self.distances().end()));
}

py::array obstacleDistancesOf(const ObstacleDistance& self, Array vertices)
{
  const auto wanted = view<std::uint32_t>(vertices, "vertices", {ANY});
  checkIndices(wanted, self.mesh().vertexCount(), "vertices");
  std::vector<float> distances;
  for (const std::uint32_t v : wanted) {
    distances.push_back(self.distances()[v]);
  }
  return toArray(std::move(distances));
}

py::array obstacleRepulsion(const ObstacleDistance& self, Array vertices, const Fading& fading,
                            unsigned threads)
{
  const auto wanted = view<std::uint32_t>(vertices, "vertices", {ANY});
  checkIndices(wanted, self.mesh().vertexCount(), "vertices");
  std::vector<float> vectors;
  {
    const py::gil_scoped_release release;
    vectors = repulsion(self, wanted, fading, threads);
  }
  return toRows(std::move(vectors), 3);
}

py::array obstacleNeighbors(const ObstacleDistance& self, Array vertices)
{
  const auto wanted = view<std::uint32_t>(vertices, "vertices", {ANY});
  checkIndices(wanted, self.mesh().vertexCount(), "vertices");
  return toArray(withNeighbors(self.mesh(), wanted));
}

py::array computeFadingCosts(Array distances, const Fading& fading, unsigned threads)
{
  const auto values = view<float>(distances, "distances", {ANY});
  std::vector<float> costs;
  {
    const py::gil_scoped_release release;
    costs = fadingCosts(values, fading, threads);
  }
  return toArray(std::move(costs));
}

}  // namespace

void bindFrontKernels(pybind11::module& module)
{
  using py::arg;
  py::class_<FrontMesh, std::shared_ptr<FrontMesh>>(module, "_FrontMesh", py::module_local())
      .def(py::init(&makeMesh), arg("vertices"), arg("faces"), arg("offsets"), arg("vertex_faces"),
           arg("threads") = 0u);
  py::class_<Fading>(module, "_Fading", py::module_local())
      .def(py::init([](double inscribed_radius, double inflation_radius, double lethal_value,
                       double inscribed_value, bool is_exponential, double cost_scaling) {
             return Fading{inscribed_radius, inflation_radius, lethal_value,
                           inscribed_value,  is_exponential,   cost_scaling};
           }),
           arg("inscribed_radius"), arg("inflation_radius"), arg("lethal_value"),
           arg("inscribed_value"), arg("is_exponential"), arg("cost_scaling"));
  py::class_<ObstacleDistance>(module, "_ObstacleDistance", py::module_local())
      .def(py::init([](std::shared_ptr<FrontMesh> mesh, float max_distance) {
             const py::gil_scoped_release release;
             return std::make_unique<ObstacleDistance>(std::move(mesh), max_distance);
           }),
           arg("mesh"), arg("max_distance"))
      .def("_compute", &computeObstacles, arg("lethal"), arg("cancel") = py::none(),
           arg("threads") = 0u)
      .def("_update", &updateObstacles, arg("lethal"))
      .def("_distances", &obstacleDistances)
      .def("_distances_of", &obstacleDistancesOf, arg("vertices"))
      .def("_repulsion", &obstacleRepulsion, arg("vertices"), arg("fading"), arg("threads") = 0u)
      .def("_with_neighbors", &obstacleNeighbors, arg("vertices"));
  module.def("_fading_costs", &computeFadingCosts, arg("distances"), arg("fading"),
             arg("threads") = 0u);
}

}  // namespace mesh_map
