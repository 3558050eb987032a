#include "level_of_detail/sorted_mesh.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

#ifdef HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace rviz_mesh_plugin {
namespace {

/// Vertices or faces that one core works on at a time.
constexpr std::size_t RUN = 65536;

#ifdef HAVE_MESHOPTIMIZER

using Centers = std::vector<std::array<float, 3>>;

Centers faceCenters(const std::vector<MeshVertex>& vertices,
                    const std::vector<std::uint32_t>& indices, const MeshRegion& region)
{
  Centers centers(indices.size() / 3);
  mesh_map::parallelEach(
      centers.size(), RUN, 0,
      [&region, corners = indices.data(), from = vertices.data(),
       to = centers.data()](std::size_t i) {
        const auto& a = from[corners[3 * i]].position;
        const auto& b = from[corners[3 * i + 1]].position;
        const auto& c = from[corners[3 * i + 2]].position;
        to[i] = region.clamp({(a[0] + b[0] + c[0]) / 3.0f, (a[1] + b[1] + c[1]) / 3.0f,
                              (a[2] + b[2] + c[2]) / 3.0f});
      });
  return centers;
}

#endif

/// Morton order, but faces that reach out of the region come first: one part has them, with all of
/// their corners.
std::vector<std::uint32_t> faceOrder(const std::vector<MeshVertex>& vertices,
                                     const std::vector<std::uint32_t>& indices,
                                     const MeshRegion& region)
{
  std::vector<std::uint32_t> order(indices.size() / 3);
  std::iota(order.begin(), order.end(), 0);
#ifdef HAVE_MESHOPTIMIZER
  if (region.hasExtent() && !indices.empty()) {
    const Centers centers = faceCenters(vertices, indices, region);
    std::vector<std::uint32_t> places(centers.size());
    meshopt_spatialSortRemap(places.data(), centers[0].data(), centers.size(), sizeof(centers[0]));
    for (std::size_t face = 0; face < places.size(); ++face) {
      order[places[face]] = static_cast<std::uint32_t>(face);
    }
  }
#endif
  if (!region.whole) {
    std::stable_partition(order.begin(), order.end(), [&](std::size_t face) {
      return std::any_of(&indices[3 * face], &indices[3 * face] + 3, [&](std::uint32_t vertex) {
        return !region.contains(vertices[vertex].position);
      });
    });
  }
  return order;
}

}  // namespace

SortedMesh sortInSpace(const std::vector<MeshVertex>& vertices,
                       const std::vector<std::uint32_t>& indices, const MeshRegion& region)
{
  SortedMesh sorted;
  sorted.faces = faceOrder(vertices, indices, region);
  sorted.indices.resize(indices.size());
  mesh_map::parallelEach(sorted.faces.size(), RUN, 0,
                         [from = indices.data(), faces = sorted.faces.data(),
                          to = sorted.indices.data()](std::size_t i) {
                           for (std::size_t corner = 0; corner < 3; ++corner) {
                             to[3 * i + corner] = from[3 * std::size_t(faces[i]) + corner];
                           }
                         });
  std::vector<std::uint32_t> places(vertices.size(), NONE);
  sorted.sources.reserve(vertices.size());
  for (std::uint32_t& index : sorted.indices) {
    std::uint32_t& place = places[index];
    if (place == NONE) {
      place = static_cast<std::uint32_t>(sorted.sources.size());
      sorted.sources.push_back(index);
    }
    index = place;
  }
  sorted.vertices.resize(sorted.sources.size());
  mesh_map::parallelEach(
      sorted.sources.size(), RUN, 0,
      [from = vertices.data(), sources = sorted.sources.data(),
       to = sorted.vertices.data()](std::size_t i) { to[i] = from[sources[i]]; });
  return sorted;
}

}  // namespace rviz_mesh_plugin
