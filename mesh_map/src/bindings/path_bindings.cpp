// Walks, footprints, shortest paths and following fields for Python (private; see mesh_map.walk,
// mesh_map.footprint, mesh_map.exact_geodesic and mesh_map.surface_path).

#include <mesh_map/paths/field_trace.h>
#include <mesh_map/paths/geodesic.h>
#include <mesh_map/paths/walk.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "base/run.h"
#include "bindings/bindings.h"
#include "bindings/spatial_bindings.h"
#include "paths/footprint.h"

namespace mesh_map {

namespace {

/// Where walks start: (N,), and (N, 3) doubles each.
struct Starts
{
  ArrayView<std::uint32_t> faces;
  ArrayView<double> barycentric, directions, ups;

  Starts(Array faces_array, Array barycentric_array, Array directions_array, Array ups_array)
      : faces(view<std::uint32_t>(faces_array, "faces", {ANY}))
  {
    const py::ssize_t count = faces_array.shape(0);
    barycentric = view<double>(barycentric_array, "barycentric", {count, 3});
    directions = view<double>(directions_array, "directions", {count, 3});
    ups = view<double>(ups_array, "up", {count, 3});
  }

  WalkPose pose(std::size_t i) const
  {
    WalkPose pose;
    pose.face = faces[i];
    std::copy_n(barycentric.data() + 3 * i, 3, pose.barycentric.begin());
    std::copy_n(directions.data() + 3 * i, 3, pose.direction.begin());
    std::copy_n(ups.data() + 3 * i, 3, pose.up.begin());
    return pose;
  }
};

/// Points and faces of a way.
py::tuple pathTuple(WalkTrace&& trace)
{
  return py::make_tuple(toRows(std::move(trace.points), 3), toArray(std::move(trace.faces)));
}

/// What N walks found, as arrays.
struct WalkArrays
{
  std::vector<std::uint32_t> faces;
  std::vector<double> barycentric, positions, directions, ups, lengths;
  std::vector<std::uint8_t> ends;

  explicit WalkArrays(std::size_t count)
      : faces(count),
        barycentric(3 * count),
        positions(3 * count),
        directions(3 * count),
        ups(3 * count),
        lengths(count),
        ends(count)
  {
  }

  void put(std::size_t i, const Walk& walk)
  {
    const auto store = [i](std::vector<double>& rows, const std::array<double, 3>& row) {
      std::copy(row.begin(), row.end(), rows.begin() + static_cast<std::ptrdiff_t>(3 * i));
    };
    faces[i] = walk.pose.face;
    store(barycentric, walk.pose.barycentric);
    store(positions, walk.position);
    store(directions, walk.pose.direction);
    store(ups, walk.pose.up);
    lengths[i] = walk.length;
    ends[i] = static_cast<std::uint8_t>(walk.end);
  }

  py::tuple toTuple(std::vector<WalkTrace>&& traces)
  {
    py::object traced = py::none();
    if (!traces.empty()) {
      py::list list;
      for (WalkTrace& trace : traces) {
        list.append(pathTuple(std::move(trace)));
      }
      traced = list;
    }
    return py::make_tuple(toArray(std::move(faces)), toRows(std::move(positions), 3),
                          toRows(std::move(barycentric), 3), toRows(std::move(directions), 3),
                          toRows(std::move(ups), 3), toArray(std::move(lengths)),
                          toArray(std::move(ends)), traced);
  }
};

/// Walks, footprints and geodesics on one mesh; keeps its arrays, which are checked once.
class SurfaceKernel
{
 public:
  SurfaceKernel(Array vertices, Array faces, Array face_edges, Array face_flags,
                Array edge_face_offsets, Array edge_faces, Array vertex_face_offsets,
                Array vertex_faces)
      : arrays_{vertices,          faces,      face_edges,          face_flags,
                edge_face_offsets, edge_faces, vertex_face_offsets, vertex_faces}
  {
    mesh_.mesh = meshView(vertices, faces);
    mesh_.face_edges = view<std::uint32_t>(face_edges, "face_edges", {faces.shape(0), 3});
    mesh_.face_flags = view<std::uint8_t>(face_flags, "face_flags", {faces.shape(0)});
    mesh_.edge_faces =
        rowsView(edge_face_offsets, edge_faces, mesh_.mesh.faceCount(), "edge_faces");
    mesh_.vertex_faces =
        rowsView(vertex_face_offsets, vertex_faces, mesh_.mesh.faceCount(), "vertex_faces");
    const WithoutGil release;
    checkWalkMesh(mesh_);
  }

  /// `lengths` (N,) for straight walks, or `targets` (N, 3) for lines.
  py::tuple walk(Array faces, Array barycentric, Array directions, Array ups, Object lengths,
                 Object targets, Object mask, std::size_t max_steps, bool trace, unsigned threads,
                 const CancelFlag* cancel) const
  {
    const Starts starts(faces, barycentric, directions, ups);
    const auto count = static_cast<py::ssize_t>(starts.faces.size());
    ArrayView<double> ways, goals;
    if (targets.is_none()) {
      ways = view<double>(py::cast<py::array>(lengths), "lengths", {count});
    } else {
      goals = view<double>(py::cast<py::array>(targets), "targets", {count, 3});
    }
    const WalkOptions options{maskOf(mask), max_steps};
    WalkArrays result(starts.faces.size());
    std::vector<WalkTrace> traces(trace ? starts.faces.size() : 0);
    const auto one = [&](std::size_t i) {
      WalkTrace* const way = trace ? &traces[i] : nullptr;
      if (!ways.empty()) {
        return walkStraight(mesh_, starts.pose(i), ways[i], options, way);
      }
      return walkLine(mesh_, starts.pose(i), {goals[3 * i], goals[3 * i + 1], goals[3 * i + 2]},
                      options, way);
    };
    runLong({threads, cancel}, starts.faces.size(), [&](const BvhOptions& how) {
      Run run(how);
      run.each(starts.faces.size(), 64, 1.0, [&](std::size_t i) {
        run.check();
        result.put(i, one(i));
      });
      run.finish();
    });
    return result.toTuple(std::move(traces));
  }

  /// One walk, as quick as can be: `length` for a straight one, or a `target`.
  py::tuple walkOne(std::uint32_t face, Object barycentric, Object direction, Object up,
                    double length, Object target, Object mask, std::size_t max_steps,
                    bool trace) const
  {
    const WalkPose start{face, vector3(barycentric, "barycentric"), vector3(direction, "direction"),
                         vector3(up, "up")};
    std::array<double, 3> goal{};
    if (!target.is_none()) {
      goal = vector3(target, "target");
    }
    const WalkOptions options{maskOf(mask), max_steps};
    WalkTrace way;
    WalkTrace* const told = trace ? &way : nullptr;
    const bool straight = target.is_none();
    const Walk walk = unlocked([&] {
      return straight ? walkStraight(mesh_, start, length, options, told)
                      : walkLine(mesh_, start, goal, options, told);
    });
    const py::object traced = trace ? py::object(pathTuple(std::move(way))) : py::none();
    return py::make_tuple(walk.pose.face, toArray3(walk.position), toArray3(walk.pose.barycentric),
                          toArray3(walk.pose.direction), toArray3(walk.pose.up), walk.length,
                          static_cast<int>(walk.end), traced);
  }

  py::tuple costsUnder(const Bvh& bvh, Array costs, Array corners, double lowest, double highest,
                       Array poses, unsigned threads, const CancelFlag* cancel) const
  {
    const auto vertex_count = static_cast<py::ssize_t>(mesh_.mesh.vertexCount());
    const auto cost_view = view<float>(costs, "costs", {vertex_count});
    const auto pose_view = view<double>(poses, "poses", {ANY, 3, 4});
    const Footprint footprint = footprintOf(corners, lowest, highest);
    FootprintCosts result =
        resultOf({threads, cancel}, pose_view.size() / 12, [&](const BvhOptions& run) {
          return footprintCosts(bvh, mesh_.mesh, cost_view, footprint, pose_view, run);
        });
    return toArrays(std::move(result.max_costs), std::move(result.lethal),
                    std::move(result.unknown), std::move(result.ground),
                    std::move(result.face_counts));
  }

  py::tuple verticesUnder(const Bvh& bvh, Array corners, double lowest, double highest, Array poses,
                          unsigned threads, const CancelFlag* cancel) const
  {
    const auto pose_view = view<double>(poses, "poses", {ANY, 3, 4});
    const Footprint footprint = footprintOf(corners, lowest, highest);
    FootprintVertices result =
        resultOf({threads, cancel}, pose_view.size() / 12, [&](const BvhOptions& run) {
          return footprintVertices(bvh, mesh_.mesh, footprint, pose_view, run);
        });
    return toArrays(std::move(result.offsets), std::move(result.vertices));
  }

  py::tuple shorten(Array points, Array faces, Object mask, bool over_hills, std::size_t max_turns,
                    const CancelFlag* cancel) const
  {
    const auto point_view = view<double>(points, "points", {ANY, 3});
    const auto face_view = view<std::uint32_t>(faces, "faces", {ANY});
    const GeodesicOptions options{maskOf(mask), over_hills, max_turns, flagOf(cancel)};
    Geodesic result = unlocked([&] {
      const WalkTrace path{{point_view.begin(), point_view.end()},
                           {face_view.begin(), face_view.end()}};
      return shortenPath(mesh_, path, options);
    });
    return py::make_tuple(toRows(std::move(result.path.points), 3),
                          toArray(std::move(result.path.faces)), result.turns, result.settled,
                          result.canceled);
  }

 private:
  static Footprint footprintOf(Array corners, double lowest, double highest)
  {
    const auto points = view<double>(corners, "footprint", {ANY, 2});
    Footprint footprint{{}, lowest, highest};
    for (std::size_t i = 0; i < points.size(); i += 2) {
      footprint.corners.push_back({points[i], points[i + 1]});
    }
    return footprint;
  }

  /// One value for each face; empty for None.
  ArrayView<std::uint8_t> maskOf(Object mask) const
  {
    return maskView(mesh_.mesh.faceCount(), mask);
  }

  std::vector<py::array> arrays_;
  WalkMesh mesh_;
};

}  // namespace

void bindQueryKernels(py::module_& module)
{
  py::class_<SurfaceKernel>(module, "_Surface", py::module_local())
      .def(py::init<Array, Array, Array, Array, Array, Array, Array, Array>())
      .def("_walk", &SurfaceKernel::walk)
      .def("_walk_one", &SurfaceKernel::walkOne)
      .def("_costs_under", &SurfaceKernel::costsUnder)
      .def("_vertices_under", &SurfaceKernel::verticesUnder)
      .def("_shorten", &SurfaceKernel::shorten);
  module.attr("_Geodesics") = module.attr("_Surface");
}

namespace {

/// A field whose arrays are kept while it is used.
struct BoundField
{
  SurfaceField field;
  py::object slowness;

  BoundField(const TraceMesh& mesh, Array labels, double limit, Object slowness_or_none,
             Object goal_face, Object goal_position)
      : slowness(slowness_or_none)
  {
    const auto count = static_cast<py::ssize_t>(mesh.mesh.vertexCount());
    field.labels = view<double>(labels, "labels", {count});
    field.limit = limit;
    field.slowness = viewOrNone<float>(slowness, "slowness", {count});
    if (!goal_face.is_none()) {
      field.goal_face = py::cast<std::uint32_t>(goal_face);
      field.goal = triple<double>(py::cast<py::array>(goal_position), "goal_position");
    }
    checkField(mesh, field);
  }
};

/// Follows fields on one mesh; keeps its arrays, which are checked once.
class FieldTracer
{
 public:
  FieldTracer(Array vertices, Array faces, Array offsets, Array vertex_faces, Array face_flags)
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
    const std::array<double, 3> start = point(face, position);
    FieldPath found;
    const TraceEnd end = unlocked([&] {
      return tracePath(mesh_, bound.field, face, start, flagOf(cancel), found, max_length);
    });
    if (end != TraceEnd::ARRIVED) {
      return py::bool_(end == TraceEnd::CANCELED);
    }
    return py::make_tuple(toRows(std::move(found.points), 3), toArray(std::move(found.faces)),
                          toArray(std::move(found.potentials)));
  }

  double value(const BoundField& bound, std::uint32_t face, Array position) const
  {
    return fieldValue(mesh_, bound.field, face, point(face, position));
  }

  py::array vertices(const BoundField& bound, const FastMarchingMesh& front, Array normals,
                     unsigned threads) const
  {
    const auto count = static_cast<py::ssize_t>(mesh_.mesh.vertexCount());
    const auto across = view<float>(normals, "vertex_normals", {count, 3});
    return toRows(
        unlocked([&] { return vertexDirections(mesh_, front, bound.field, across, threads); }), 3);
  }

  py::array faces(const BoundField& bound, unsigned threads) const
  {
    return toRows(unlocked([&] { return faceDirections(mesh_, bound.field, threads); }), 3);
  }

 private:
  std::array<double, 3> point(std::uint32_t face, Array position) const
  {
    requireValue(face < mesh_.mesh.faceCount(),
                 "face " + std::to_string(face) + " does not exist: there are " +
                     std::to_string(mesh_.mesh.faceCount()) + " faces");
    return triple<double>(position, "position");
  }

  std::vector<py::array> arrays_;
  TraceMesh mesh_;
};

}  // namespace

void bindTraceKernels(py::module_& module)
{
  using py::arg;
  py::class_<BoundField>(module, "_BoundField", py::module_local());
  py::class_<FieldTracer>(module, "_FieldTracer", py::module_local())
      .def(py::init<Array, Array, Array, Array, Array>())
      .def("_bind", &FieldTracer::bind, py::keep_alive<0, 2>(), py::keep_alive<0, 1>())
      .def("_path", &FieldTracer::path, arg("field"), arg("face"), arg("position"), arg("cancel"),
           arg("max_length") = std::numeric_limits<double>::infinity())
      .def("_value", &FieldTracer::value)
      .def("_vertex_directions", &FieldTracer::vertices, arg("field"), arg("front"), arg("normals"),
           arg("threads") = 0u)
      .def("_face_directions", &FieldTracer::faces, arg("field"), arg("threads") = 0u);
}

}  // namespace mesh_map
