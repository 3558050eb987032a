#include "bvh/tree/bvh_tree.h"

#include <cstddef>
#include <limits>

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

}  // namespace mesh_map
