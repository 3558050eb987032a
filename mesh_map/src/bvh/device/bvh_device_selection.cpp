#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <string>

#include "base/run.h"
#include "bvh/device/device_frame.h"
#include "bvh/selection/bvh_selection_filters.h"
#include "bvh/selection/bvh_selection_sort.h"

namespace mesh_map {

namespace {

/// Work items that keep a device busy: trees are split until there are so many.
constexpr std::size_t ENOUGH_ROOTS = 1024;

/// Larger numbers leave everything unsure: fourth powers are to be floats.
constexpr double LARGEST = 1e8;

struct Subtree
{
  std::uint32_t child, first, count;
};

/// The children of these subtrees that the region may touch; leaves stay.
template <class Filter>
std::vector<Subtree> childrenOf(const Bvh& bvh, const Filter& filter,
                                const std::vector<Subtree>& trees)
{
  std::vector<Subtree> children;
  ChildSides sides;
  for (const Subtree& tree : trees) {
    if (isLeaf(tree.child)) {
      children.push_back(tree);
      continue;
    }
    const BvhNode& node = bvh.nodes()[tree.child];
    filter.children(node, filter.cutting(), sides);
    std::uint32_t first = tree.first;
    for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
      if (node.child[k] != BVH_NO_CHILD && sides.side[k] != Side::OUTSIDE) {
        children.push_back({node.child[k], first, node.count[k]});
      }
      first += node.count[k];
    }
  }
  return children;
}

template <class Filter>
std::vector<Subtree> split(const Bvh& bvh, const Filter& filter)
{
  std::vector<Subtree> trees = {{0, 0, static_cast<std::uint32_t>(bvh.faceCount())}};
  const auto is_leaf = [](const Subtree& tree) { return isLeaf(tree.child); };
  while (trees.size() < ENOUGH_ROOTS && !std::all_of(trees.begin(), trees.end(), is_leaf)) {
    trees = childrenOf(bvh, filter, trees);
  }
  return trees;
}

/// Bound of what a region rounds in double precision, for numbers of this size.
float roundingOf(const DeviceFrame& mesh, double numbers)
{
  return mesh.usable ? roundedUp(0x1p-44 * numbers) : std::numeric_limits<float>::infinity();
}

}  // namespace

std::vector<std::uint32_t> selectionRoots(const Bvh& bvh, const Region& region)
{
  std::vector<Subtree> trees;
  if (const auto* const sphere = dynamic_cast<const SphereRegion*>(&region)) {
    if (sphere->valid()) {
      trees = split(bvh, SphereFilter(bvh, *sphere));
    }
  } else if (const auto* const convex = dynamic_cast<const ConvexRegion*>(&region)) {
    if (convex->valid()) {
      trees = split(bvh, ConvexFilter(bvh, *convex));
    }
  } else {
    throw std::invalid_argument("devices select by spheres and planes only");
  }
  std::vector<std::uint32_t> roots;
  roots.reserve(2 * trees.size());
  for (const Subtree& tree : trees) {
    roots.push_back(tree.child);
    roots.push_back(isLeaf(tree.child) ? tree.count : tree.first);
  }
  return roots;
}

std::vector<float> packSphere(const Bvh& bvh, const SphereRegion& sphere)
{
  const DeviceFrame mesh(bvh);
  std::vector<float> packed(16, 0.0f);
  double numbers = sphere.radius(), away = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double place = sphere.center()[k];
    numbers = std::max({numbers, std::abs(place), std::abs(mesh.center[k]), mesh.reach[k]});
    away = std::max(away, std::abs(place - mesh.center[k]));
  }
  if (!sphere.valid()) {
    packed[3] = packed[7] = -1.0f;
    return packed;
  }
  if (!(numbers <= LARGEST)) {
    packed[12] = std::numeric_limits<float>::infinity();
    return packed;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const double place = sphere.center()[k];
    packed[k] = static_cast<float>(place);
    packed[k + 4] = static_cast<float>(place - packed[k]);
    packed[k + 8] = static_cast<float>(place - mesh.center[k]);
  }
  packed[3] = static_cast<float>(sphere.radius() * (1.0 - 0x1p-22));
  packed[7] = roundedUp(sphere.radius());
  packed[11] = roundedUp(0x1p-22 * away + 0x1p-44 * numbers);
  packed[12] = roundingOf(mesh, numbers) + 1e-17f;
  return packed;
}

std::vector<float> packPlanes(const Bvh& bvh, const ConvexRegion& region)
{
  const DeviceFrame mesh(bvh);
  std::vector<float> packed(4 + 8 * region.planes().size(), 0.0f);
  std::copy(bvh.center().begin(), bvh.center().end(), packed.begin());
  float* at = packed.data() + 4;
  for (const Plane& plane : region.planes()) {
    double numbers = std::abs(plane[3]), height = plane[3];
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = static_cast<float>(plane[k]);
      numbers += std::abs(plane[k]) * (std::abs(mesh.center[k]) + mesh.reach[k]);
      height += plane[k] * mesh.center[k];
    }
    at[3] = static_cast<float>(std::max(-1e30, std::min(1e30, height)));
    at[4] = roundingOf(mesh, numbers);
    at += 8;
  }
  return packed;
}

std::vector<std::uint32_t> finishSelection(const Bvh& bvh, const Region& region, SelectionMode mode,
                                           ArrayView<std::uint8_t> mask,
                                           ArrayView<std::uint8_t> verdicts,
                                           const BvhOptions& run_options)
{
  checkMask(bvh, mask);
  if (verdicts.size() != bvh.faceCount()) {
    throw std::invalid_argument(std::to_string(verdicts.size()) +
                                " verdicts of a device do not fit " +
                                std::to_string(bvh.faceCount()) + " faces: one for each");
  }
  const auto isSelected = [&](std::size_t i) {
    std::uint8_t verdict = verdicts[i];
    if (verdict > DEVICE_INSIDE) {
      const Side side = region.triangle(bvh.corners().data() + 9 * i);
      verdict = side == Side::OUTSIDE    ? DEVICE_OUTSIDE
                : side == Side::TOUCHING ? DEVICE_TOUCHING
                                         : DEVICE_INSIDE;
    }
    return verdict == DEVICE_INSIDE ||
           (verdict == DEVICE_TOUCHING && mode == SelectionMode::TOUCHING);
  };
  std::mutex mutex;
  std::vector<TriangleRange> all;
  Run run(run_options);
  constexpr std::size_t chunk = 16384;
  run.loop(verdicts.size(), chunk, 1.0, [&]() -> RangeBody {
    return [&, ranges = std::vector<TriangleRange>()](std::size_t begin, std::size_t end) mutable {
      ranges.clear();
      for (std::size_t i = begin; i < end; ++i) {
        if (verdicts[i] == DEVICE_OUTSIDE || !isSelected(i)) {
          continue;
        }
        const auto at = static_cast<std::uint32_t>(i);
        if (!ranges.empty() && ranges.back().end == at) {
          ++ranges.back().end;
        } else {
          ranges.push_back({at, at + 1});
        }
      }
      const std::lock_guard<std::mutex> lock(mutex);
      all.insert(all.end(), ranges.begin(), ranges.end());
    };
  });
  run.finish();
  return facesOf(bvh.faces(), all, mask);
}

}  // namespace mesh_map
