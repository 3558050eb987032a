#pragma once

#include <mesh_map/base/large_array.h>
#include <mesh_map/bvh/tree/bvh_node.h>

#include <cstdint>
#include <vector>

#include "bvh/tree/bvh_clusters.h"
#include "bvh/tree/bvh_split.h"
#include "bvh/tree/bvh_tree.h"

namespace mesh_map {

class Run;

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
