#pragma once

#include <mesh_map/base/large_array.h>
#include <mesh_map/bvh/tree/bvh_node.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "bvh/tree/bvh_clusters.h"
#include "bvh/tree/bvh_split.h"

namespace mesh_map {

class Run;

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

/// A part of the tree that one thread makes.
struct BvhSubtree
{
  std::uint32_t first_cluster, end_cluster;  ///< in BvhTop::clusters
  std::uint32_t first;                       ///< of its triangles, in the order of the leaves
  std::uint32_t count;
  unsigned level;              ///< of its root
  std::vector<BvhNode> nodes;  ///< children are relative to the first of them, leaves are not

  /// Few triangles need no node of their own, but below the top there has to be one.
  bool isLeaf() const { return count <= BVH_LEAF_SIZE && level > 0; }
};

/// The part of the tree above. A leaf in it stands for a subtree.
struct BvhTop
{
  std::vector<BvhNode> nodes;
  std::vector<BvhSubtree> subtrees;
  std::vector<std::uint32_t> clusters;  ///< in the order of the leaves
};

BvhTop makeTop(const BvhClusters& clusters, const Run& run);

/// Makes subtrees: small clusters are divided first, and then, where few triangles are left, these.
class BvhSubtreeMaker
{
 public:
  BvhSubtreeMaker(const MeshView& mesh, const LocalFrame& frame, const BvhClusters& clusters,
                  const BvhTop& top, const Run& run);

  /// Fills in the nodes, and the faces and their corners at their places.
  void make(BvhSubtree& subtree, std::uint32_t* faces, float* corners);

 private:
  void gather(const BvhSubtree& subtree);
  std::uint32_t divideClusters(const BvhSpan& span, unsigned level);
  std::uint32_t divideTriangles(const BvhSpan& span, unsigned level);

  const MeshView& mesh_;
  const LocalFrame& frame_;
  const BvhClusters& clusters_;
  const BvhTop& top_;
  const Run& run_;

  LargeArray<BvhItem> gathered_;             // all triangles, cluster by cluster
  LargeArray<std::uint32_t> begins_;         // per small cluster and at the end: in gathered_
  LargeArray<BvhItem> small_, other_small_;  // clusters
  LargeArray<BvhItem> triangles_, other_triangles_;  // of some of them
  BvhTree tree_;
  std::vector<BvhNode> nodes_;
  std::uint32_t place_ = 0;         // of the next triangle, in the order of the leaves
  std::uint32_t* faces_ = nullptr;  // in that order
};

}  // namespace mesh_map
