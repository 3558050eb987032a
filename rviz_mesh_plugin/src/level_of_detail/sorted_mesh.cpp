#include "level_of_detail/sorted_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "level_of_detail/mesh_layout.h"
#include "threads/parallel_each.h"

#ifdef HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace rviz_mesh_plugin {
namespace {

#ifdef HAVE_MESHOPTIMIZER

using Centers = std::vector<std::array<float, 3>>;

/// Blocks of faces are ordered so that parts have small boxes. The Morton order of faces alone
/// would cut slopes into strips.
constexpr std::size_t BLOCK_FACES = 128;
/// Blocks end where the next face is this many times as far as usual, too: a block that leaps would
/// make the box of its part large.
constexpr float LEAP = 16.0f;

Centers faceCenters(const MeshData& mesh, const MeshRegion& region)
{
  Centers centers(mesh.faceCount());
  parallelEach(mesh.faceCount(),
               [&region, indices = mesh.indices.data(), vertices = mesh.vertices.data(),
                to = centers.data()](std::size_t i) {
                 const auto& a = vertices[indices[3 * i]].position;
                 const auto& b = vertices[indices[3 * i + 1]].position;
                 const auto& c = vertices[indices[3 * i + 2]].position;
                 to[i] = region.clamp({(a[0] + b[0] + c[0]) / 3.0f, (a[1] + b[1] + c[1]) / 3.0f,
                                       (a[2] + b[2] + c[2]) / 3.0f});
               });
  return centers;
}

struct Block
{
  const std::uint32_t* first;  ///< its faces
  const std::uint32_t* last;
  std::array<float, 3> center;
};

float squaredDistance(const std::array<float, 3>& a, const std::array<float, 3>& b)
{
  const float x = a[0] - b[0];
  const float y = a[1] - b[1];
  const float z = a[2] - b[2];
  return x * x + y * y + z * z;
}

/// The square of the longest step from face to face that is no leap.
float squaredLeap(const Centers& centers, const std::vector<std::uint32_t>& order)
{
  std::vector<float> steps;
  const std::size_t stride = std::max<std::size_t>(1, order.size() / 20000);
  for (std::size_t i = 1; i < order.size(); i += stride) {
    steps.push_back(squaredDistance(centers[order[i - 1]], centers[order[i]]));
  }
  if (steps.empty()) {
    return 0.0f;
  }
  std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
  return LEAP * LEAP * steps[steps.size() / 2];
}

std::vector<Block> makeBlocks(const Centers& centers, const std::vector<std::uint32_t>& order)
{
  const float leap = squaredLeap(centers, order);
  std::vector<Block> blocks;
  const std::uint32_t* const end = order.data() + order.size();
  for (const std::uint32_t* face = order.data(); face != end; ++face) {
    if (blocks.empty() || static_cast<std::size_t>(face - blocks.back().first) == BLOCK_FACES ||
        squaredDistance(centers[face[-1]], centers[*face]) > leap) {
      blocks.push_back({face, face, {}});
    }
    blocks.back().last = face + 1;
  }
  for (Block& block : blocks) {
    block.center = centers[block.first[(block.last - block.first) / 2]];
  }
  return blocks;
}

/// Halves the blocks along their longest axis until a half makes one part.
void orderBlocks(Block* first, Block* last)
{
  std::size_t faces = 0;
  auto lower = first->center;
  auto upper = lower;
  for (const Block* block = first; block != last; ++block) {
    faces += block->last - block->first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], block->center[axis]);
      upper[axis] = std::max(upper[axis], block->center[axis]);
    }
  }
  if (faces <= PART_FACES) {
    std::sort(first, last, [](const Block& a, const Block& b) { return a.first < b.first; });
    return;
  }
  std::size_t longest = 0;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    longest = upper[axis] - lower[axis] > upper[longest] - lower[longest] ? axis : longest;
  }
  Block* middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [longest](const Block& a, const Block& b) {
    return std::make_pair(a.center[longest], a.first) < std::make_pair(b.center[longest], b.first);
  });
  orderBlocks(first, middle);
  orderBlocks(middle, last);
}

std::vector<std::uint32_t> orderOfFaces(const MeshData& mesh, const MeshRegion& region)
{
  const Centers centers = faceCenters(mesh, region);
  std::vector<std::uint32_t> places(mesh.faceCount());
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

std::vector<std::uint32_t> faceOrder(const MeshData& mesh, const MeshRegion& region)
{
#ifdef HAVE_MESHOPTIMIZER
  if (region.hasExtent()) {
    return orderOfFaces(mesh, region);
  }
#else
  static_cast<void>(region);
#endif
  std::vector<std::uint32_t> order(mesh.faceCount());
  std::iota(order.begin(), order.end(), 0);
  return order;
}

}  // namespace

SortedMesh sortInSpace(const MeshData& mesh, const MeshRegion& region)
{
  SortedMesh sorted;
  sorted.faces = faceOrder(mesh, region);
  sorted.indices.resize(mesh.indices.size());
  parallelEach(sorted.faces.size(), [from = mesh.indices.data(), faces = sorted.faces.data(),
                                     to = sorted.indices.data()](std::size_t i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      to[3 * i + corner] = from[3 * std::size_t(faces[i]) + corner];
    }
  });
  std::vector<std::uint32_t> places(mesh.vertexCount(), NONE);
  sorted.sources.reserve(mesh.vertexCount());
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
               [from = mesh.vertices.data(), sources = sorted.sources.data(),
                to = sorted.vertices.data()](std::size_t i) { to[i] = from[sources[i]]; });
  return sorted;
}

}  // namespace rviz_mesh_plugin
