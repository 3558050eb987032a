#pragma once

#include <mesh_map/bvh/tree/bvh_node.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "bvh/tree/bvh_split.h"

namespace mesh_map {

/// Whether a branch on this level (the root's is 0) may divide so many triangles as it likes:
/// however unevenly it does, the levels below suffice. Else it has to halve them.
bool maySplitFreely(std::uint32_t count, unsigned level);

/// A tree of which each branch has two children, and how its branches are best put together to
/// nodes of up to BVH_WIDTH children: so that the surfaces of all nodes have the least sum, which
/// is how many nodes rays visit.
class BvhTree
{
 public:
  /// Makes it empty, for triangles in this box. It says what little a node costs by itself.
  void reset(const FloatBox& box, std::uint32_t count);

  /// Both return the number of the new branch.
  std::uint32_t addLeaf(const FloatBox& box, std::uint32_t first, std::uint32_t count);
  std::uint32_t addBranch(const FloatBox& box, std::uint32_t left, std::uint32_t right);

  /// The same of two spans, the left one first, that `divide` makes the numbers of branches of.
  template <class Divide>
  std::uint32_t addBranch(const FloatBox& box, const std::pair<BvhSpan, BvhSpan>& sides,
                          const Divide& divide)
  {
    const std::uint32_t left = divide(sides.first);
    return addBranch(box, left, divide(sides.second));
  }

  /// Appends the nodes below a branch, depth first, the branch itself being the first of them.
  void appendNodes(std::uint32_t branch, std::vector<BvhNode>& nodes) const;

 private:
  struct Branch
  {
    FloatBox box;
    std::uint32_t count;        // triangles
    std::uint32_t left, right;  // leaves: first triangle, BVH_NO_CHILD
    float costs[3];             // least cost of all below in one, two or three children of a node
    std::uint8_t left_children[5];  // of so many children (2, 3, 4), those of the left branch
    bool divided[4];                // whether in so many children (2, 3) is better than in fewer

    bool isLeaf() const { return right == BVH_NO_CHILD; }
  };

  struct Children
  {
    std::uint32_t size = 0, branches[BVH_WIDTH];
  };

  void collect(std::uint32_t branch, unsigned size, Children& children) const;

  std::vector<Branch> branches_;
  float node_cost_ = 0.0f;
};

}  // namespace mesh_map
