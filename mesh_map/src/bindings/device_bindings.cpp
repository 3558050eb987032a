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
  const auto of_faces = maskView(bvh.faceCount(), mask);
  return toArray(unlocked([&] { return deviceMask(bvh, of_faces); }));
}

py::array pack(const Bvh& bvh, Array origins, Array directions, Array max_distances,
               unsigned threads)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  return toArray(resultOf({threads}, rays.size(),
                          [&](const BvhOptions& run) { return packRays(bvh, rays, run); }));
}

/// finishRays() or finishRaysAny().
template <class Finish>
auto finish(const Bvh& bvh, Array origins, Array directions, Array max_distances, bool back_faces,
            Object mask, Array answers, unsigned threads, const Finish& finish_rays)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  const RayOptions options = rayOptions(bvh, back_faces, mask);
  const auto found = view<std::uint32_t>(answers, "answers", {ANY});
  return resultOf({threads}, rays.size(), [&](const BvhOptions& run) {
    return finish_rays(bvh, rays, options, found, run);
  });
}

py::tuple finishCast(const Bvh& bvh, Array origins, Array directions, Array max_distances,
                     bool back_faces, Object mask, Array answers, unsigned threads)
{
  return toTuple(finish(bvh, origins, directions, max_distances, back_faces, mask, answers, threads,
                        finishRays));
}

py::array finishAny(const Bvh& bvh, Array origins, Array directions, Array max_distances,
                    bool back_faces, Object mask, Array answers, unsigned threads)
{
  return toArray(finish(bvh, origins, directions, max_distances, back_faces, mask, answers, threads,
                        finishRaysAny));
}

py::array packPointsOf(const Bvh& bvh, Array points, double max_distance, unsigned threads)
{
  const auto queries = view<double>(points, "points", {ANY, 3});
  ClosestOptions options;
  options.max_distance = max_distance;
  return toArray(resultOf({threads}, queries.size() / 3, [&](const BvhOptions& run) {
    return packPoints(bvh, queries, options, run);
  }));
}

py::tuple finishPointsOf(const Bvh& bvh, Array points, double max_distance, Object mask,
                         Array answers, unsigned threads)
{
  const auto queries = view<double>(points, "points", {ANY, 3});
  ClosestOptions options;
  options.max_distance = max_distance;
  options.mask = maskView(bvh.faceCount(), mask);
  const auto found = view<std::uint32_t>(answers, "answers", {ANY});
  return toTuple(resultOf({threads}, queries.size() / 3, [&](const BvhOptions& run) {
    return finishPoints(bvh, queries, options, found, run);
  }));
}

/// Roots (R, 2), and how many triangles are below them.
py::tuple rootsOf(const Bvh& bvh, const Region& region)
{
  std::vector<std::uint32_t> roots = unlocked([&] { return selectionRoots(bvh, region); });
  std::size_t below = 0;
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
  const auto mask_view = maskView(bvh.faceCount(), mask);
  const auto size = static_cast<py::ssize_t>(bvh.faceCount());
  const auto of_triangles = view<std::uint8_t>(verdicts, "verdicts", {size});
  return toArray(unlocked(
      [&] { return finishSelection(bvh, region, modeOf(inside), mask_view, of_triangles); }));
}

}  // namespace

void bindDevice(py::module_& module, BvhClass& bvh)
{
  module.attr("_BVH_KERNELS") = BVH_KERNELS;
  module.attr("_BVH_KERNEL_OPTIONS") = BVH_KERNEL_OPTIONS;
  module.attr("_DEVICE_WORK_GROUP") = DEVICE_WORK_GROUP;
  module.attr("_DEVICE_BACK_FACES") = DEVICE_BACK_FACES;
  module.attr("_DEVICE_MASKED") = DEVICE_MASKED;
  module.attr("_DEVICE_ANY_HIT") = DEVICE_ANY_HIT;
  module.attr("_DEVICE_RAY_ANSWERS") = DEVICE_RAY_ANSWERS;
  module.attr("_DEVICE_CANDIDATES") = DEVICE_CANDIDATES;
  module.def("_count_opencl", [](const std::string& query, std::uint64_t count) {
    countQueries(BackEnd::OPENCL, queryOf(query), count);
  });
  module.def("_query_counts", &queryCounts);
  module.def("_device_threshold", [](const std::string& query, bool is_gpu) {
    return deviceThreshold(queryOf(query), is_gpu);
  });
  bvh.def("_device_mask", &toDeviceMask)
      .def("_pack_rays", &pack)
      .def("_finish_rays", &finishCast)
      .def("_finish_rays_any", &finishAny)
      .def("_pack_points", &packPointsOf)
      .def("_finish_points", &finishPointsOf)
      .def("_selection_roots", &rootsOf)
      .def("_pack_region", &packRegion)
      .def("_finish_selection", &finishSelectionOf);
}

}  // namespace mesh_map
