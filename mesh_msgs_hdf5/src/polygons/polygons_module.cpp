// Polygons in the plane to triangles, for mesh_msgs_hdf5.formats.base.concave, which see.
#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "polygons/ear_clipping.h"

namespace py = pybind11;

namespace mesh_msgs_hdf5 {
namespace {
// of comparisons, some seconds: for all polygons together, and for one (legitimate ones take about
// 3 n^2)
constexpr std::int64_t MOST_STEPS = std::int64_t{4} << 30;

std::int64_t stepsOf(std::size_t corners)
{
  return 20 * static_cast<std::int64_t>(corners) * static_cast<std::int64_t>(corners) + 10000;
}

/// Triangles (sum of n - 2, 3) int64, as places in the list of all points, and for each polygon 1
/// if it crosses itself or could not be cut soundly, else 0.
///
/// points: (N, 2) of all polygons, one after the other; counts: (P,), three or more each.
std::pair<py::array, py::array> triangulate(
    const py::array_t<double, py::array::c_style>& points,
    const py::array_t<std::int64_t, py::array::c_style>& counts)
{
  if (points.ndim() != 2 || points.shape(1) != 2 || counts.ndim() != 1) {
    throw std::invalid_argument("points must be (N, 2), counts (P,)");
  }
  std::int64_t total = 0, triangle_count = 0;
  for (py::ssize_t i = 0; i < counts.shape(0); ++i) {
    if (counts.at(i) < 3 || counts.at(i) > points.shape(0) - total) {
      throw std::invalid_argument("a polygon has fewer than three corners, or more than there are");
    }
    total += counts.at(i);
    triangle_count += counts.at(i) - 2;
  }
  py::array_t<std::int64_t> triangles({triangle_count, std::int64_t{3}});
  py::array_t<std::uint8_t> unsound(counts.shape(0));
  const double* point = points.data();
  const std::int64_t* count = counts.data();
  std::int64_t* place = triangles.mutable_data();
  std::uint8_t* flag = unsound.mutable_data();
  const auto polygon_count = static_cast<std::size_t>(counts.shape(0));
  {
    const py::gil_scoped_release release;
    std::vector<Point> polygon;
    std::vector<Corners> found;
    std::int64_t all_steps = MOST_STEPS, first = 0;
    for (std::size_t i = 0; i < polygon_count; ++i) {
      polygon.clear();
      for (std::int64_t j = 0; j < count[i]; ++j, point += 2) {
        polygon.push_back({point[0], point[1]});
      }
      const std::int64_t given = std::min(all_steps, stepsOf(polygon.size()));
      std::int64_t steps = given;
      found.clear();
      const bool sound = EarClipping(polygon, steps).run(found);
      flag[i] = sound && !crossesItself(polygon, steps) ? 0 : 1;
      all_steps = std::max(all_steps - (given - steps), std::int64_t{0});
      for (const Corners& corners : found) {
        for (const std::int64_t corner : corners) {
          *place++ = first + corner;
        }
      }
      first += count[i];
    }
  }
  return {triangles, unsound};
}

}  // namespace

PYBIND11_MODULE(_polygons, module)
{
  module.def("_triangulate", &triangulate, py::arg("points"), py::arg("counts"));
}

}  // namespace mesh_msgs_hdf5
