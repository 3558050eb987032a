#include <algorithm>
#include <utility>

#include "bvh_run.h"
#include "bvh_subtrees.h"

namespace mesh_map {

namespace {

/// Triangles of a subtree at most, where the tree is not too deep.
constexpr std::uint32_t SUBTREE_SIZE = 8192;

/// Divides clusters, which stay whole.
class TopMaker
{
 public:
  TopMaker(const BvhClusters& clusters, BvhTop& top, const Run& run)
      : items_(clusters.items), others_(items_.size()), top_(top), run_(run)
  {
  }

  void make()
  {
    BvhSpan all = {0, static_cast<std::uint32_t>(items_.size()), 0, 0, {}};
    for (const BvhItem& item : items_) {
      all.box.add(item);
      all.count += item.count();
    }
    tree_.reset(all.box, all.count);
    const std::uint32_t root = divide(all, 0);
    if (top_.subtrees.size() > 1) {
      tree_.appendNodes(root, top_.nodes);
      setLevels(0, 0);
    }
  }

 private:
  std::uint32_t divide(const BvhSpan& span, unsigned level)
  {
    run_.check();
    const BvhSplitter splitter(items_.data(), others_.data());
    if (span.count > SUBTREE_SIZE && maySplitFreely(span.count, level)) {
      const auto sides = splitter.split(span);
      const std::uint32_t left = divide(sides.first, level + 1);
      const std::uint32_t right = divide(sides.second, level + 1);
      return tree_.addBranch(span.box, left, right);
    }
    const auto first_cluster = static_cast<std::uint32_t>(top_.clusters.size());
    const BvhItem* const items = splitter.items(span);
    for (const BvhItem* item = items; item < items + span.items(); ++item) {
      top_.clusters.push_back(item->index());
    }
    top_.subtrees.push_back(
        {first_cluster, first_cluster + span.items(), triangles_, span.count, 0, {}});
    triangles_ += span.count;
    const auto number = static_cast<std::uint32_t>(top_.subtrees.size() - 1);
    return tree_.addLeaf(span.box, number, span.count);
  }

  void setLevels(std::uint32_t node, unsigned level)
  {
    for (const std::uint32_t child : top_.nodes[node].child) {
      if (!isLeaf(child)) {
        setLevels(child, level + 1);
      } else if (child != BVH_NO_CHILD) {
        top_.subtrees[child & ~BVH_LEAF].level = level + 1;
      }
    }
  }

  LargeArray<BvhItem> items_, others_;
  BvhTop& top_;
  const Run& run_;
  BvhTree tree_;
  std::uint32_t triangles_ = 0;
};

}  // namespace

BvhTop makeTop(const BvhClusters& clusters, const Run& run)
{
  BvhTop top;
  top.clusters.reserve(clusters.items.size());
  TopMaker(clusters, top, run).make();
  return top;
}

}  // namespace mesh_map
