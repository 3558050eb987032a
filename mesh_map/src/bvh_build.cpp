#include <algorithm>
#include <memory>
#include <utility>

#include "bvh_boxes.h"
#include "bvh_check.h"
#include "bvh_clusters.h"
#include "bvh_frame.h"
#include "bvh_run.h"
#include "bvh_subtrees.h"

namespace mesh_map {

namespace {

constexpr double CLUSTER_SHARE = 0.35, SUBTREE_SHARE = 0.6, COPY_SHARE = 0.05;

}  // namespace

/// Puts a hierarchy together: clusters of triangles along a Morton curve, the top of the tree over
/// these clusters, and then, side by side, subtrees over the triangles. What the parts are does not
/// depend on the number of threads.
class BvhBuilder
{
 public:
  BvhBuilder(Bvh& bvh, const MeshView& mesh, Run& run) : bvh_(bvh), mesh_(mesh), run_(run) {}

  void build()
  {
    const FaceSample sample(mesh_);
    bvh_.center_ = sample.center();
    const LocalFrame frame(bvh_.center_);
    const BvhClusters clusters = findClusters(mesh_, sample, frame, run_, CLUSTER_SHARE);
    top_ = makeTop(clusters, run_);

    const std::size_t count = mesh_.faceCount();
    bvh_.faces_ = LargeArray<std::uint32_t>(count);
    bvh_.corners_ = LargeArray<float>(9 * count + Bvh::TAIL);
    std::fill(bvh_.corners_.end() - Bvh::TAIL, bvh_.corners_.end(), 0.0f);
    run_.loop(top_.subtrees.size(), 1, SUBTREE_SHARE, [&]() -> RangeBody {
      auto maker = std::make_shared<BvhSubtreeMaker>(mesh_, frame, clusters, top_, run_);
      return [this, maker](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          maker->make(top_.subtrees[i], bvh_.faces_.data(), bvh_.corners_.data());
        }
      };
    });
    join();
    bvh_.setBox();
  }

 private:
  /// Brings all nodes into depth-first order.
  void join()
  {
    std::size_t total = top_.nodes.size();
    for (const BvhSubtree& subtree : top_.subtrees) {
      total += subtree.nodes.size();
    }
    bvh_.nodes_ = LargeArray<BvhNode>(total);
    offsets_.resize(top_.subtrees.size());
    if (top_.nodes.empty()) {
      offsets_[0] = 0;
    } else {
      placeTop(0);
    }
    run_.loop(top_.subtrees.size(), 1, COPY_SHARE, [&]() -> RangeBody {
      return [this](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          placeSubtree(top_.subtrees[i], offsets_[i]);
        }
      };
    });
  }

  /// Returns what BvhNode::child says.
  std::uint32_t placeTop(std::uint32_t index)
  {
    const std::uint32_t place = next_++;
    BvhNode node = top_.nodes[index];
    for (std::uint32_t& child : node.child) {
      if (!isLeaf(child)) {
        child = placeTop(child);
      } else if (child != BVH_NO_CHILD) {
        const std::uint32_t i = child & ~BVH_LEAF;
        const BvhSubtree& subtree = top_.subtrees[i];
        offsets_[i] = next_;
        child = subtree.isLeaf() ? BVH_LEAF | subtree.first : next_;
        next_ += static_cast<std::uint32_t>(subtree.nodes.size());
      }
    }
    bvh_.nodes_[place] = node;
    return place;
  }

  void placeSubtree(BvhSubtree& subtree, std::uint32_t offset)
  {
    BvhNode* to = bvh_.nodes_.data() + offset;
    for (const BvhNode& node : subtree.nodes) {
      *to = node;
      for (std::uint32_t& child : to->child) {
        child += isLeaf(child) ? 0 : offset;
      }
      ++to;
    }
    subtree.nodes = {};
  }

  Bvh& bvh_;
  const MeshView& mesh_;
  Run& run_;
  BvhTop top_;
  std::vector<std::uint32_t> offsets_;  // of the nodes of subtrees
  std::uint32_t next_ = 0;
};

Bvh Bvh::build(const MeshView& mesh, const BvhOptions& options)
{
  Run run(options);
  run.check();
  checkFaceCount(mesh);
  Bvh bvh;
  BvhBuilder(bvh, mesh, run).build();
  run.finish();
  return bvh;
}

void Bvh::setBox()
{
  const FloatBox box = boxOf(nodes_[0]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lower_[axis] = box.lower[static_cast<int>(axis)];
    upper_[axis] = box.upper[static_cast<int>(axis)];
  }
}

std::size_t Bvh::memory() const
{
  return nodes_.capacity() * sizeof(BvhNode) + corners_.capacity() * sizeof(float) +
         faces_.capacity() * sizeof(std::uint32_t);
}

}  // namespace mesh_map
