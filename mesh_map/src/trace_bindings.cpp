// Following fields for Python (private; see mesh_map.surface_path).

#include "trace_bindings.h"

#include <mesh_map/field_trace.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "array_checks.h"
#include "cancel_flag.h"

namespace mesh_map {
namespace {

using Array = const py::array&;
using Object = const py::object&;

/// A field whose arrays are kept while it is used.
struct BoundField
{
  SurfaceField field;
  py::array slowness;

  BoundField(const TraceMesh& mesh, Array labels, double limit, Object slowness_or_none,
             Object goal_face, Object goal_position)
  {
    const auto count = static_cast<py::ssize_t>(mesh.mesh.vertexCount());
    field.labels = view<double>(labels, "labels", {count});
    field.limit = limit;
    if (!slowness_or_none.is_none()) {
      slowness = py::cast<py::array>(slowness_or_none);
      field.slowness = view<float>(slowness, "slowness", {count});
    }
    if (!goal_face.is_none()) {
      field.goal_face = py::cast<std::uint32_t>(goal_face);
      const auto goal = py::cast<py::array>(goal_position);
      std::copy_n(view<double>(goal, "goal_position", {3}).data(), 3, field.goal.begin());
    }
    checkField(mesh, field);
  }
};

/// Follows fields on one mesh; keeps its arrays, which are checked once.
class FieldTracer
{
 public:
  FieldTracer(const py::array& vertices, const py::array& faces, const py::array& offsets,
              const py::array& vertex_faces, const py::array& face_flags)
      : arrays_{vertices, faces, offsets, vertex_faces, face_flags}
  {
    mesh_.mesh = meshView(vertices, faces);
    mesh_.vertex_faces = rowsView(offsets, vertex_faces, mesh_.mesh.faceCount(), "vertex_faces");
    mesh_.face_flags = view<std::uint8_t>(face_flags, "face_flags", {faces.shape(0)});
    requireValue(mesh_.vertex_faces.rowCount() == mesh_.mesh.vertexCount(),
                 "vertex_faces need one row per vertex");
  }

  BoundField bind(Array labels, double limit, Object slowness, Object goal_face,
                  Object goal_position) const
  {
    return {mesh_, labels, limit, slowness, goal_face, goal_position};
  }

  py::object path(const BoundField& bound, std::uint32_t face, Array position,
                  const CancelFlag* cancel, double max_length) const
  {
    const Vector start = point(face, position);
    FieldPath found;
    TraceEnd end = TraceEnd::NOT_REACHED;
    {
      const py::gil_scoped_release release;
      end = tracePath(mesh_, bound.field, face, start, cancel == nullptr ? nullptr : &cancel->flag,
                      found, max_length);
    }
    if (end != TraceEnd::ARRIVED) {
      return py::bool_(end == TraceEnd::CANCELLED);
    }
    return py::make_tuple(toRows(std::move(found.points), 3), toArray(std::move(found.faces)),
                          toArray(std::move(found.potentials)));
  }

  double value(const BoundField& bound, std::uint32_t face, Array position) const
  {
    return fieldValue(mesh_, bound.field, face, point(face, position));
  }

  py::array vertices(const BoundField& bound, const FrontMesh& front, Array normals,
                     unsigned threads) const
  {
    const auto count = static_cast<py::ssize_t>(mesh_.mesh.vertexCount());
    const auto across = view<float>(normals, "vertex_normals", {count, 3});
    LargeArray<float> directions;
    {
      const py::gil_scoped_release release;
      directions = vertexDirections(mesh_, front, bound.field, across, threads);
    }
    return toRows(std::move(directions), 3);
  }

  py::array faces(const BoundField& bound, unsigned threads) const
  {
    LargeArray<float> directions;
    {
      const py::gil_scoped_release release;
      directions = faceDirections(mesh_, bound.field, threads);
    }
    return toRows(std::move(directions), 3);
  }

 private:
  using Vector = std::array<double, 3>;

  Vector point(std::uint32_t face, Array position) const
  {
    requireValue(face < mesh_.mesh.faceCount(),
                 "face " + std::to_string(face) + " does not exist: there are " +
                     std::to_string(mesh_.mesh.faceCount()) + " faces");
    Vector result;
    std::copy_n(view<double>(position, "position", {3}).data(), 3, result.begin());
    return result;
  }

  std::vector<py::array> arrays_;
  TraceMesh mesh_;
};

}  // namespace

void bindTraceKernels(pybind11::module& module)
{
  using py::arg;
  py::class_<BoundField>(module, "_BoundField", py::module_local());
  py::class_<FieldTracer>(module, "_FieldTracer", py::module_local())
      .def(py::init<const py::array&, const py::array&, const py::array&, const py::array&,
                    const py::array&>(),
           arg("vertices"), arg("faces"), arg("offsets"), arg("vertex_faces"), arg("face_flags"))
      .def("_bind", &FieldTracer::bind, arg("labels"), arg("limit"), arg("slowness"),
           arg("goal_face"), arg("goal_position"), py::keep_alive<0, 2>(), py::keep_alive<0, 1>())
      .def("_path", &FieldTracer::path, arg("field"), arg("face"), arg("position"), arg("cancel"),
           arg("max_length") = std::numeric_limits<double>::infinity())
      .def("_value", &FieldTracer::value, arg("field"), arg("face"), arg("position"))
      .def("_vertex_directions", &FieldTracer::vertices, arg("field"), arg("front"), arg("normals"),
           arg("threads") = 0u)
      .def("_face_directions", &FieldTracer::faces, arg("field"), arg("threads") = 0u);
}

}  // namespace mesh_map
