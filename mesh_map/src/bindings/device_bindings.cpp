// What Python does before and after the OpenCL kernels (private; see mesh_map.opencl), and which
// back end answers what.

#include <mesh_map/bvh/device/bvh_device.h>
#include <mesh_map/bvh/tree/back_end.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <string>
#include <utility>

#include "bindings/spatial_bindings.h"

namespace mesh_map {

namespace {

using Array = const py::array&;
using Object = const py::object&;

constexpr const char* QUERY_NAMES[] = {"ray", "closest_point", "sphere", "frustum", "lasso"};
static_assert(std::size(QUERY_NAMES) == QUERIES, "one name per query");

Query queryOf(const std::string& name)
{
  const auto* const found = std::find(std::begin(QUERY_NAMES), std::end(QUERY_NAMES), name);
  requireValue(found != std::end(QUERY_NAMES), "there is no query " + name);
  return static_cast<Query>(found - std::begin(QUERY_NAMES));
}

py::dict queryCounts()
{
  py::dict counts;
  const std::pair<const char*, BackEnd> back_ends[] = {{"native", BackEnd::NATIVE},
                                                       {"opencl", BackEnd::OPENCL}};
  for (const auto& back_end : back_ends) {
    py::dict row;
    for (std::size_t query = 0; query < QUERIES; ++query) {
      row[QUERY_NAMES[query]] = queryCount(back_end.second, static_cast<Query>(query));
    }
    counts[back_end.first] = row;
  }
  return counts;
}

py::array toDeviceMask(const Bvh& bvh, Array mask)
{
  const auto of_faces = maskView(bvh, mask);
  std::vector<std::uint8_t> of_triangles;
  {
    const py::gil_scoped_release release;
    of_triangles = deviceMask(bvh, of_faces);
  }
  return toArray(std::move(of_triangles));
}

RunArguments onThreads(unsigned threads)
{
  RunArguments run;
  run.threads = threads;
  return run;
}

py::array pack(const Bvh& bvh, Array origins, Array directions, Array max_distances,
               unsigned threads)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  std::vector<float> packed;
  runLong(onThreads(threads), rays.size(),
          [&](const BvhOptions& run) { packed = packRays(bvh, rays, run); });
  return toArray(std::move(packed));
}

py::tuple finish(const Bvh& bvh, Array origins, Array directions, Array max_distances,
                 bool back_faces, Object mask, Array answers, unsigned threads)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  const RayOptions options{back_faces, maskView(bvh, mask)};
  const auto found = view<std::uint32_t>(answers, "answers", {ANY});
  RayHits hits;
  runLong(onThreads(threads), rays.size(),
          [&](const BvhOptions& run) { hits = finishRays(bvh, rays, options, found, run); });
  return toTuple(std::move(hits));
}

py::array finishAny(const Bvh& bvh, Array origins, Array directions, Array max_distances,
                    bool back_faces, Object mask, Array answers, unsigned threads)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  const RayOptions options{back_faces, maskView(bvh, mask)};
  const auto found = view<std::uint32_t>(answers, "answers", {ANY});
  std::vector<std::uint8_t> hits;
  runLong(onThreads(threads), rays.size(),
          [&](const BvhOptions& run) { hits = finishRaysAny(bvh, rays, options, found, run); });
  return toArray(std::move(hits));
}

py::array packPointsOf(const Bvh& bvh, Array points, double max_distance, unsigned threads)
{
  const auto queries = view<double>(points, "points", {ANY, 3});
  ClosestOptions options;
  options.max_distance = max_distance;
  std::vector<float> packed;
  runLong(onThreads(threads), queries.size() / 3,
          [&](const BvhOptions& run) { packed = packPoints(bvh, queries, options, run); });
  return toArray(std::move(packed));
}

py::tuple finishPointsOf(const Bvh& bvh, Array points, double max_distance, Object mask,
                         Array answers, unsigned threads)
{
  const auto queries = view<double>(points, "points", {ANY, 3});
  ClosestOptions options;
  options.max_distance = max_distance;
  options.mask = maskView(bvh, mask);
  const auto found = view<std::uint32_t>(answers, "answers", {ANY});
  SurfaceHits hits;
  runLong(onThreads(threads), queries.size() / 3,
          [&](const BvhOptions& run) { hits = finishPoints(bvh, queries, options, found, run); });
  return toTuple(std::move(hits));
}

/// Roots (R, 2), and how many triangles are below them.
py::tuple rootsOf(const Bvh& bvh, const Region& region)
{
  std::vector<std::uint32_t> roots;
  std::size_t below = 0;
  {
    const py::gil_scoped_release release;
    roots = selectionRoots(bvh, region);
  }
  for (std::size_t i = 0; i < roots.size(); i += 2) {
    if (isLeaf(roots[i])) {
      below += roots[i + 1];
    } else {
      const BvhNode& node = bvh.nodes()[roots[i]];
      below = std::accumulate(std::begin(node.count), std::end(node.count), below);
    }
  }
  return py::make_tuple(toRows(std::move(roots), 2), below);
}

/// The region for a kernel, and the number of its planes: 0 for a ball, none for what has no
/// kernel.
py::tuple packRegion(const Bvh& bvh, const Region& region)
{
  if (const auto* const sphere = dynamic_cast<const SphereRegion*>(&region)) {
    return py::make_tuple(toArray(packSphere(bvh, *sphere)), 0);
  }
  if (const auto* const convex = dynamic_cast<const ConvexRegion*>(&region)) {
    return py::make_tuple(toArray(packPlanes(bvh, *convex)), convex->planes().size());
  }
  throw py::value_error("no kernel selects by this region");
}

py::array finishSelectionOf(const Bvh& bvh, const Region& region, bool inside, Object mask,
                            Array verdicts)
{
  const auto mask_view = maskView(bvh, mask);
  const auto size = static_cast<py::ssize_t>(bvh.faceCount());
  const auto of_triangles = view<std::uint8_t>(verdicts, "verdicts", {size});
  std::vector<std::uint32_t> faces;
  {
    const py::gil_scoped_release release;
    faces = finishSelection(bvh, region, inside ? SelectionMode::INSIDE : SelectionMode::TOUCHING,
                            mask_view, of_triangles);
  }
  return toArray(std::move(faces));
}

}  // namespace

void bindDevice(py::module_& module, BvhClass& bvh)
{
  using py::arg;

  module.attr("_BVH_KERNELS") = BVH_KERNELS;
  module.attr("_BVH_KERNEL_OPTIONS") = BVH_KERNEL_OPTIONS;
  module.attr("_DEVICE_WORK_GROUP") = DEVICE_WORK_GROUP;
  module.attr("_DEVICE_BACK_FACES") = DEVICE_BACK_FACES;
  module.attr("_DEVICE_MASKED") = DEVICE_MASKED;
  module.attr("_DEVICE_ANY_HIT") = DEVICE_ANY_HIT;
  module.attr("_DEVICE_RAY_ANSWERS") = DEVICE_RAY_ANSWERS;
  module.attr("_DEVICE_RAY_FLOATS") = DEVICE_RAY_FLOATS;
  module.attr("_DEVICE_CANDIDATES") = DEVICE_CANDIDATES;
  module.attr("_DEVICE_POINT_FLOATS") = DEVICE_POINT_FLOATS;
  module.def(
      "_count_opencl",
      [](const std::string& query, std::uint64_t count) {
        countQueries(BackEnd::OPENCL, queryOf(query), count);
      },
      arg("query"), arg("count"));
  module.def("_query_counts", &queryCounts);
  module.def(
      "_device_threshold",
      [](const std::string& query, bool is_gpu) { return deviceThreshold(queryOf(query), is_gpu); },
      arg("query"), arg("is_gpu"));
  bvh.def("_device_mask", &toDeviceMask, arg("mask"))
      .def("_pack_rays", &pack, arg("origins"), arg("directions"), arg("max_distances"),
           arg("threads"))
      .def("_finish_rays", &finish, arg("origins"), arg("directions"), arg("max_distances"),
           arg("back_faces"), arg("mask"), arg("answers"), arg("threads"))
      .def("_finish_rays_any", &finishAny, arg("origins"), arg("directions"), arg("max_distances"),
           arg("back_faces"), arg("mask"), arg("answers"), arg("threads"))
      .def("_pack_points", &packPointsOf, arg("points"), arg("max_distance"), arg("threads"))
      .def("_finish_points", &finishPointsOf, arg("points"), arg("max_distance"), arg("mask"),
           arg("answers"), arg("threads"))
      .def("_selection_roots", &rootsOf, arg("region"))
      .def("_pack_region", &packRegion, arg("region"))
      .def("_finish_selection", &finishSelectionOf, arg("region"), arg("inside"), arg("mask"),
           arg("verdicts"));
}

}  // namespace mesh_map
