#include <mesh_map/bvh/selection/bvh_selection.h>

#include <mesh_map/bvh/tree/back_end.h>

#include "base/run.h"
#include "bvh/selection/bvh_selection_filters.h"
#include "bvh/selection/bvh_selection_sort.h"

namespace mesh_map {

namespace {

/// A subtree of triangles from `first` on that touches the region, or is in it.
struct Subtree
{
  std::uint32_t child, first, count;
  std::uint32_t cutting;
  bool inside;
};

void append(std::vector<TriangleRange>& ranges, std::uint32_t begin, std::uint32_t end)
{
  if (!ranges.empty() && ranges.back().end == begin) {
    ranges.back().end = end;
  } else {
    ranges.push_back({begin, end});
  }
}

/// Subtrees after which a selection looks whether it is canceled.
constexpr std::size_t PATIENCE = 1024;

/// The triangles that the region of the filter selects.
template <class Filter>
std::vector<TriangleRange> select(const Bvh& bvh, const Filter& filter, SelectionMode mode,
                                  const Run& run)
{
  const auto isSelected = [mode](Side side) {
    return side == Side::INSIDE || (side == Side::TOUCHING && mode == SelectionMode::TOUCHING);
  };
  std::vector<TriangleRange> ranges;
  ChildSides sides;
  std::array<Subtree, BVH_STACK> stack;
  std::size_t size = 0;
  stack[size++] = {0, 0, static_cast<std::uint32_t>(bvh.faceCount()), filter.cutting(), false};
  for (std::size_t taken = 0; size > 0; ++taken) {
    if (taken % PATIENCE == 0) {
      run.check();
    }
    const Subtree tree = stack[--size];
    if (tree.inside) {
      append(ranges, tree.first, tree.first + tree.count);
      continue;
    }
    if (isLeaf(tree.child)) {
      for (std::uint32_t i = tree.first; i < tree.first + tree.count; ++i) {
        if (isSelected(filter.triangle(bvh.corners().data() + 9 * std::size_t{i}, tree.cutting))) {
          append(ranges, i, i + 1);
        }
      }
      continue;
    }
    const BvhNode& node = bvh.nodes()[tree.child];
    filter.children(node, tree.cutting, sides);
    std::uint32_t first = tree.first + tree.count;
    for (std::size_t k = BVH_WIDTH; k-- > 0;) {  // the first child is taken first
      first -= node.count[k];
      if (sides.side[k] != Side::OUTSIDE) {
        stack[size++] = {node.child[k], first, node.count[k], sides.cutting[k],
                         sides.side[k] == Side::INSIDE};
      }
    }
  }
  return ranges;
}

}  // namespace

std::vector<std::uint32_t> selectFaces(const Bvh& bvh, const Region& region, SelectionMode mode,
                                       ArrayView<std::uint8_t> mask, const BvhOptions& options)
{
  const Run run(options);
  std::vector<TriangleRange> ranges;
  const auto selectBy = [&](const auto& filter, Query query) {
    if (region.valid()) {
      ranges = select(bvh, filter, mode, run);
    }
    countQueries(BackEnd::NATIVE, query, 1);
  };
  if (const auto* const sphere = dynamic_cast<const SphereRegion*>(&region)) {
    selectBy(SphereFilter(bvh, *sphere), Query::SPHERE);
  } else if (const auto* const convex = dynamic_cast<const ConvexRegion*>(&region)) {
    selectBy(ConvexFilter(bvh, *convex), Query::FRUSTUM);
  } else if (const auto* const lasso = dynamic_cast<const LassoRegion*>(&region)) {
    selectBy(LassoFilter(bvh, *lasso), Query::LASSO);
  }
  return facesOf(bvh.faces(), ranges, mask);
}

}  // namespace mesh_map
