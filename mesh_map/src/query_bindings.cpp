// Walks, footprints and adjacency for Python (private; see mesh_map.walk, mesh_map.footprint and
// mesh_map.topology).

#include "query_bindings.h"

#include <mesh_map/edge_faces.h>
#include <mesh_map/footprint.h>
#include <mesh_map/footprint_vertices.h>
#include <mesh_map/walk.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "bvh_run.h"
#include "spatial_bindings.h"
#include "walk_mesh_arrays.h"

namespace mesh_map {
namespace {

using Array = const py::array&;
using Object = const py::object&;

py::tuple edgeRows(Array face_edges, std::size_t edge_count)
{
  const auto edges = view<std::uint32_t>(face_edges, "face_edges", {ANY, 3});
  EdgeFaces rows;
  {
    const py::gil_scoped_release release;
    rows = edgeFaces(edges, edge_count);
  }
  return py::make_tuple(toArray(std::move(rows.offsets)), toArray(std::move(rows.faces)));
}

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
        list.append(
            py::make_tuple(toRows(std::move(trace.points), 3), toArray(std::move(trace.faces))));
      }
      traced = list;
    }
    return py::make_tuple(toArray(std::move(faces)), toRows(std::move(positions), 3),
                          toRows(std::move(barycentric), 3), toRows(std::move(directions), 3),
                          toRows(std::move(ups), 3), toArray(std::move(lengths)),
                          toArray(std::move(ends)), traced);
  }
};

/// Walks and footprints on one mesh; keeps its arrays, which are checked once.
class SurfaceKernel
{
 public:
  SurfaceKernel(const py::array& vertices, const py::array& faces, const py::array& face_edges,
                const py::array& face_flags, const py::array& edge_face_offsets,
                const py::array& edge_faces)
      : arrays_(vertices, faces, face_edges, face_flags, edge_face_offsets, edge_faces),
        mesh_(arrays_.mesh())
  {
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
    const WalkOptions options{arrays_.maskOf(mask), max_steps};
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
    runLong({threads, cancel, py::none()}, starts.faces.size(), [&](const BvhOptions& how) {
      Run run(how);
      run.loop(starts.faces.size(), 64, 1.0, [&]() -> RangeBody {
        return [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            run.check();
            result.put(i, one(i));
          }
        };
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
    const WalkOptions options{arrays_.maskOf(mask), max_steps};
    WalkTrace way;
    WalkTrace* const told = trace ? &way : nullptr;
    Walk walk;
    {
      const py::gil_scoped_release release;
      walk = target.is_none() ? walkStraight(mesh_, start, length, options, told)
                              : walkLine(mesh_, start, goal, options, told);
    }
    py::object traced = py::none();
    if (trace) {
      traced = py::make_tuple(toRows(std::move(way.points), 3), toArray(std::move(way.faces)));
    }
    const auto row = [](const std::array<double, 3>& values) {
      return py::array_t<double>(3, values.data());
    };
    return py::make_tuple(walk.pose.face, row(walk.position), row(walk.pose.barycentric),
                          row(walk.pose.direction), row(walk.pose.up), walk.length,
                          static_cast<int>(walk.end), traced);
  }

  py::tuple costsUnder(const Bvh& bvh, Array costs, Array corners, double lowest, double highest,
                       Array poses, unsigned threads, const CancelFlag* cancel) const
  {
    const auto vertex_count = static_cast<py::ssize_t>(mesh_.mesh.vertexCount());
    const auto cost_view = view<float>(costs, "costs", {vertex_count});
    const auto pose_view = view<double>(poses, "poses", {ANY, 3, 4});
    const Footprint footprint = footprintOf(corners, lowest, highest);
    FootprintCosts result;
    runLong({threads, cancel, py::none()}, static_cast<std::size_t>(poses.shape(0)),
            [&](const BvhOptions& run) {
              result = footprintCosts(bvh, mesh_.mesh, cost_view, footprint, pose_view, run);
            });
    return py::make_tuple(toArray(std::move(result.max_costs)), toArray(std::move(result.lethal)),
                          toArray(std::move(result.unknown)), toArray(std::move(result.ground)),
                          toArray(std::move(result.face_counts)));
  }

  py::tuple verticesUnder(const Bvh& bvh, Array corners, double lowest, double highest, Array poses,
                          unsigned threads, const CancelFlag* cancel) const
  {
    const auto pose_view = view<double>(poses, "poses", {ANY, 3, 4});
    const Footprint footprint = footprintOf(corners, lowest, highest);
    FootprintVertices result;
    runLong({threads, cancel, py::none()}, static_cast<std::size_t>(poses.shape(0)),
            [&](const BvhOptions& run) {
              result = footprintVertices(bvh, mesh_.mesh, footprint, pose_view, run);
            });
    return py::make_tuple(toArray(std::move(result.offsets)), toArray(std::move(result.vertices)));
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

  WalkMeshArrays arrays_;
  const WalkMesh& mesh_;
};

}  // namespace

void bindQueryKernels(py::module_& module)
{
  using py::arg;

  module.def("_edge_faces", &edgeRows, arg("face_edges"), arg("edge_count"));
  py::class_<SurfaceKernel>(module, "_Surface", py::module_local())
      .def(py::init<const py::array&, const py::array&, const py::array&, const py::array&,
                    const py::array&, const py::array&>(),
           arg("vertices"), arg("faces"), arg("face_edges"), arg("face_flags"),
           arg("edge_face_offsets"), arg("edge_faces"))
      .def("_walk", &SurfaceKernel::walk, arg("faces"), arg("barycentric"), arg("directions"),
           arg("ups"), arg("lengths"), arg("targets"), arg("mask"), arg("max_steps"), arg("trace"),
           arg("threads"), arg("cancel"))
      .def("_walk_one", &SurfaceKernel::walkOne, arg("face"), arg("barycentric"), arg("direction"),
           arg("up"), arg("length"), arg("target"), arg("mask"), arg("max_steps"), arg("trace"))
      .def("_costs_under", &SurfaceKernel::costsUnder, arg("bvh"), arg("costs"), arg("footprint"),
           arg("lowest"), arg("highest"), arg("poses"), arg("threads"), arg("cancel"))
      .def("_vertices_under", &SurfaceKernel::verticesUnder, arg("bvh"), arg("footprint"),
           arg("lowest"), arg("highest"), arg("poses"), arg("threads"), arg("cancel"));
}

}  // namespace mesh_map
