#include "level_of_detail/sorted_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "level_of_detail/face_blocks.h"
#include "level_of_detail/mesh_layout.h"
#include "threads/parallel_each.h"

#ifdef HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace rviz_mesh_plugin {
namespace {

#ifdef HAVE_MESHOPTIMIZER

using Centers = std::vector<std::array<float, 3>>;

Centers faceCenters(const std::vector<MeshVertex>& vertices,
                    const std::vector<std::uint32_t>& indices, const MeshRegion& region)
{
  Centers centers(indices.size() / 3);
  parallelEach(centers.size(), [&region, corners = indices.data(), from = vertices.data(),
                                to = centers.data()](std::size_t i) {
    const auto& a = from[corners[3 * i]].position;
    const auto& b = from[corners[3 * i + 1]].position;
    const auto& c = from[corners[3 * i + 2]].position;
    to[i] = region.clamp(
        {(a[0] + b[0] + c[0]) / 3.0f, (a[1] + b[1] + c[1]) / 3.0f, (a[2] + b[2] + c[2]) / 3.0f});
  });
  return centers;
}

/// Blocks of faces are ordered so that parts have small boxes. The Morton order of faces alone
/// would cut slopes into strips.
struct Block
{
  const std::uint32_t* first;  ///< its faces
  const std::uint32_t* last;
  std::array<float, 3> center;
};

std::vector<Block> makeBlocks(const Centers& centers, const std::vector<std::uint32_t>& order)
{
  const auto begins = cutIntoBlocks(
      order.size(), [&](std::size_t place) -> const auto& { return centers[order[place]]; },
      [](std::size_t) { return false; });
  std::vector<Block> blocks;
  for (std::size_t i = 1; i < begins.size(); ++i) {
    blocks.push_back({order.data() + begins[i - 1], order.data() + begins[i],
                      centers[order[(begins[i - 1] + begins[i]) / 2]]});
  }
  return blocks;
}

/// Halves the blocks along their longest axis until a half makes one part.
void orderBlocks(Block* first, Block* last)
{
  std::size_t faces = 0;
  Bounds box = Bounds::none();
  for (const Block* block = first; block != last; ++block) {
    faces += block->last - block->first;
    box.enclose(block->center);
  }
  if (faces <= PART_FACES) {
    std::sort(first, last, [](const Block& a, const Block& b) { return a.first < b.first; });
    return;
  }
  const auto sides = box.sides();
  const std::size_t longest = std::max_element(sides.begin(), sides.end()) - sides.begin();
  Block* middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [longest](const Block& a, const Block& b) {
    return std::make_pair(a.center[longest], a.first) < std::make_pair(b.center[longest], b.first);
  });
  orderBlocks(first, middle);
  orderBlocks(middle, last);
}

std::vector<std::uint32_t> orderOfFaces(const Centers& centers)
{
  std::vector<std::uint32_t> places(centers.size());
  meshopt_spatialSortRemap(places.data(), centers[0].data(), centers.size(), sizeof(centers[0]));
  std::vector<std::uint32_t> morton(places.size());
  for (std::size_t face = 0; face < places.size(); ++face) {
    morton[places[face]] = static_cast<std::uint32_t>(face);
  }
  std::vector<Block> blocks = makeBlocks(centers, morton);
  orderBlocks(blocks.data(), blocks.data() + blocks.size());
  std::vector<std::uint32_t> order;
  order.reserve(morton.size());
  for (const Block& block : blocks) {
    order.insert(order.end(), block.first, block.last);
  }
  return order;
}

#endif

std::vector<std::uint32_t> faceOrder(const std::vector<MeshVertex>& vertices,
                                     const std::vector<std::uint32_t>& indices,
                                     const MeshRegion& region)
{
#ifdef HAVE_MESHOPTIMIZER
  if (region.hasExtent()) {
    return orderOfFaces(faceCenters(vertices, indices, region));
  }
#else
  static_cast<void>(vertices);
  static_cast<void>(region);
#endif
  std::vector<std::uint32_t> order(indices.size() / 3);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

}  // namespace

SortedMesh sortInSpace(const std::vector<MeshVertex>& vertices,
                       const std::vector<std::uint32_t>& indices, const MeshRegion& region)
{
  SortedMesh sorted;
  sorted.faces = faceOrder(vertices, indices, region);
  sorted.indices.resize(indices.size());
  parallelEach(sorted.faces.size(), [from = indices.data(), faces = sorted.faces.data(),
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
  parallelEach(sorted.sources.size(),
               [from = vertices.data(), sources = sorted.sources.data(),
                to = sorted.vertices.data()](std::size_t i) { to[i] = from[sources[i]]; });
  return sorted;
}

}  // namespace rviz_mesh_plugin
