// Shortest paths over a surface for Python (private; see mesh_map.exact_geodesic).

#include "geodesic_bindings.h"

#include <mesh_map/geodesic.h>

#include <utility>

#include "array_checks.h"
#include "cancel_flag.h"
#include "walk_mesh_arrays.h"

namespace mesh_map {
namespace {

py::tuple shorten(const WalkMeshArrays& self, const py::array& points, const py::array& faces,
                  const py::object& mask, bool over_hills, std::size_t max_turns,
                  const CancelFlag* cancel)
{
  const auto point_view = view<double>(points, "points", {ANY, 3});
  const auto face_view = view<std::uint32_t>(faces, "faces", {ANY});
  const GeodesicOptions options{self.maskOf(mask), over_hills, max_turns,
                                cancel == nullptr ? nullptr : &cancel->flag};
  Geodesic result;
  {
    const py::gil_scoped_release release;
    const WalkTrace path{{point_view.begin(), point_view.end()},
                         {face_view.begin(), face_view.end()}};
    result = shortenPath(self.mesh(), path, options);
  }
  return py::make_tuple(toRows(std::move(result.path.points), 3),
                        toArray(std::move(result.path.faces)), result.turns, result.settled,
                        result.cancelled);
}

}  // namespace

void bindGeodesicKernels(py::module& module)
{
  using py::arg;
  py::class_<WalkMeshArrays>(module, "_Geodesics", py::module_local())
      .def(py::init<const py::array&, const py::array&, const py::array&, const py::array&,
                    const py::array&, const py::array&>(),
           arg("vertices"), arg("faces"), arg("face_edges"), arg("face_flags"),
           arg("edge_face_offsets"), arg("edge_faces"))
      .def("_shorten", &shorten, arg("points"), arg("faces"), arg("mask"), arg("over_hills"),
           arg("max_turns"), arg("cancel"));
}

}  // namespace mesh_map
