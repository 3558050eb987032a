#include "bvh/tree/bvh_subtrees.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "base/run.h"
#include "bvh/tree/bvh_boxes.h"

namespace mesh_map {

namespace {

/// What a node costs by itself, for the memory that it takes, in surfaces of a typical leaf.
constexpr float NODE_COST = 0.5f;

BvhNode emptyNode()
{
  BvhNode node;
  for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.lower[axis][k] = std::numeric_limits<float>::infinity();
      node.upper[axis][k] = -std::numeric_limits<float>::infinity();
    }
    node.child[k] = BVH_NO_CHILD;
    node.count[k] = 0;
  }
  return node;
}

}  // namespace

bool maySplitFreely(std::uint32_t count, unsigned level)
{
  // Halves of halves: n levels reach 2^n leaves. One side may get nearly all.
  const auto below = static_cast<unsigned>(BVH_DEPTH) - 1 - level;
  return below >= 32 || leafBlocks(count) <= std::uint32_t{1} << below;
}

void BvhTree::reset(const FloatBox& box, std::uint32_t count)
{
  branches_.clear();
  node_cost_ = NODE_COST * halfArea(box) / static_cast<float>(leafBlocks(count));
  if (!(node_cost_ >= std::numeric_limits<float>::min())) {
    node_cost_ = std::numeric_limits<float>::min();
  }
}

std::uint32_t BvhTree::addLeaf(const FloatBox& box, std::uint32_t first, std::uint32_t count)
{
  // Leaves are as they are, whatever the nodes above them: they cost nothing here.
  branches_.push_back({box, count, first, BVH_NO_CHILD, {}, {}, {}});
  return static_cast<std::uint32_t>(branches_.size() - 1);
}

// The cost of a branch as one, two or three children of a node above (H. Ylitie, T. Karras, S.
// Laine: Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, 2017).
std::uint32_t BvhTree::addBranch(const FloatBox& box, std::uint32_t left, std::uint32_t right)
{
  const Branch &l = branches_[left], &r = branches_[right];
  Branch branch = {box, l.count + r.count, left, right, {}, {}, {}};
  float least[5];
  for (unsigned size = 2; size <= 4; ++size) {
    least[size] = l.costs[0] + r.costs[size - 2];
    branch.left_children[size] = 1;
    for (unsigned i = 2; i < size; ++i) {
      const float cost = l.costs[i - 1] + r.costs[size - i - 1];
      if (cost < least[size]) {
        least[size] = cost;
        branch.left_children[size] = static_cast<std::uint8_t>(i);
      }
    }
  }
  branch.costs[0] = halfArea(box) + node_cost_ + least[4];
  for (unsigned size = 2; size <= 3; ++size) {
    branch.divided[size] = least[size] < branch.costs[size - 2];
    branch.costs[size - 1] = branch.divided[size] ? least[size] : branch.costs[size - 2];
  }
  branches_.push_back(branch);
  return static_cast<std::uint32_t>(branches_.size() - 1);
}

void BvhTree::collect(std::uint32_t index, unsigned size, Children& children) const
{
  const Branch& branch = branches_[index];
  while (size > 1 && size < 4 && !branch.divided[size]) {
    --size;
  }
  if (branch.isLeaf() || size == 1) {
    children.branches[children.size++] = index;
  } else {
    const unsigned of_left = branch.left_children[size];
    collect(branch.left, of_left, children);
    collect(branch.right, size - of_left, children);
  }
}

void BvhTree::appendNodes(std::uint32_t branch, std::vector<BvhNode>& nodes) const
{
  const std::size_t index = nodes.size();
  nodes.push_back(emptyNode());
  Children children;
  collect(branch, BVH_WIDTH, children);
  for (std::uint32_t k = 0; k < children.size; ++k) {
    const Branch& child = branches_[children.branches[k]];
    BvhNode& node = nodes[index];
    for (int axis = 0; axis < 3; ++axis) {
      node.lower[axis][k] = child.box.lower[axis];
      node.upper[axis][k] = child.box.upper[axis];
    }
    node.count[k] = child.count;
    node.child[k] =
        child.isLeaf() ? BVH_LEAF | child.left : static_cast<std::uint32_t>(nodes.size());
    if (!child.isLeaf()) {
      appendNodes(children.branches[k], nodes);
    }
  }
}

namespace {

/// Triangles of a small cluster at most.
constexpr std::uint32_t SMALL_CLUSTER = 8;

/// From so many triangles down they are divided one by one: what rays gain by doing it earlier is
/// below a percent.
constexpr std::uint32_t FEW_TRIANGLES = 256;

void makeRoom(LargeArray<BvhItem>& items, std::size_t size)
{
  if (items.size() < size) {
    items = LargeArray<BvhItem>();
    items = LargeArray<BvhItem>(size);
  }
}

}  // namespace

BvhSubtreeMaker::BvhSubtreeMaker(const MeshView& mesh, const LocalFrame& frame,
                                 const BvhClusters& clusters, const BvhTop& top, const Run& run)
    : mesh_(mesh), frame_(frame), clusters_(clusters), top_(top), run_(run)
{
}

void BvhSubtreeMaker::make(BvhSubtree& subtree, std::uint32_t* faces, float* corners)
{
  faces_ = faces;
  gather(subtree);
  const auto small_clusters = static_cast<std::uint32_t>(begins_.size() - 1);
  BvhSpan all = {0, small_clusters, 0, subtree.count, {}};
  for (std::uint32_t i = 0; i < small_clusters; ++i) {
    all.box.add(small_[i]);
  }
  place_ = subtree.first;
  tree_.reset(all.box, all.count);
  const std::uint32_t root = divideClusters(all, subtree.level);
  if (!subtree.isLeaf()) {
    nodes_.clear();
    tree_.appendNodes(root, nodes_);
    subtree.nodes = nodes_;
  }
  copyCorners(mesh_, faces, subtree.first, subtree.first + std::size_t{subtree.count}, corners);
}

void BvhSubtreeMaker::gather(const BvhSubtree& subtree)
{
  // The place of the faces in the order of the leaves serves to list them in this order first.
  std::uint32_t* const list = faces_ + subtree.first;
  makeRoom(gathered_, subtree.count);
  makeRoom(small_, subtree.count);
  makeRoom(other_small_, subtree.count);
  makeRoom(triangles_, subtree.count);
  makeRoom(other_triangles_, subtree.count);
  const KeyedIndex* const faces = clusters_.faces.data();
  begins_.clear();
  std::uint32_t gathered = 0;
  for (std::uint32_t i = subtree.first_cluster; i < subtree.end_cluster; ++i) {
    const std::uint32_t begin = clusters_.begins[top_.clusters[i]];
    const std::uint32_t end = clusters_.begins[top_.clusters[i] + 1];
    const std::size_t first_small = begins_.size();
    appendCells(faces, begin, end, SMALL_CLUSTER, begins_);
    for (std::size_t small = first_small; small < begins_.size(); ++small) {
      begins_[small] += gathered - begin;
    }
    for (std::uint32_t k = begin; k < end; ++k) {
      list[gathered++] = faces[k].index;
    }
  }
  begins_.push_back(gathered);
  forEachFace(
      mesh_, gathered, [list](std::size_t i) { return list[i]; },
      [&](std::size_t i) { gathered_[i] = BvhItem(frame_.box(mesh_, list[i]), list[i], 1); });
  for (std::uint32_t i = 0; i + 1 < begins_.size(); ++i) {
    FloatBox box;
    for (std::uint32_t k = begins_[i]; k < begins_[i + 1]; ++k) {
      box.add(gathered_[k]);
    }
    small_[i] = BvhItem(box, i, begins_[i + 1] - begins_[i]);
  }
}

std::uint32_t BvhSubtreeMaker::divideClusters(const BvhSpan& span, unsigned level)
{
  const BvhSplitter splitter(small_.data(), other_small_.data());
  if (span.count > FEW_TRIANGLES && maySplitFreely(span.count, level)) {
    return tree_.addBranch(span.box, splitter.split(span),
                           [&](const BvhSpan& side) { return divideClusters(side, level + 1); });
  }
  run_.check();
  BvhItem* to = triangles_.data();
  const BvhItem* const items = splitter.items(span);
  for (const BvhItem* item = items; item < items + span.items(); ++item) {
    const std::uint32_t small = item->index();
    to = std::copy(gathered_.data() + begins_[small], gathered_.data() + begins_[small + 1], to);
  }
  const std::uint32_t first = place_;
  const std::uint32_t branch = divideTriangles({0, span.count, 0, span.count, span.box}, level);
  place_ = first + span.count;
  return branch;
}

std::uint32_t BvhSubtreeMaker::divideTriangles(const BvhSpan& span, unsigned level)
{
  const BvhSplitter splitter(triangles_.data(), other_triangles_.data());
  if (span.count <= BVH_LEAF_SIZE) {
    const BvhItem* const items = splitter.items(span);
    for (std::uint32_t i = 0; i < span.count; ++i) {
      faces_[place_ + span.begin + i] = items[i].index();
    }
    return tree_.addLeaf(span.box, place_ + span.begin, span.count);
  }
  const auto sides =
      maySplitFreely(span.count, level) ? splitter.split(span) : splitter.halve(span);
  return tree_.addBranch(span.box, sides,
                         [&](const BvhSpan& side) { return divideTriangles(side, level + 1); });
}

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
      return tree_.addBranch(span.box, splitter.split(span),
                             [&](const BvhSpan& side) { return divide(side, level + 1); });
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
