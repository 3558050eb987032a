#pragma once

#include "bvh/rays/ray_beam.h"
#include "bvh/rays/ray_test.h"

namespace mesh_map {

/// A ray on its way through a tree.
struct RaySearch
{
  RaySearch(const Bvh& bvh, const Ray& ray)
      : test(ray), beam(bvh, test), limit(beam.depth(test.maxDistance()))
  {
    best.distance = test.maxDistance();
  }

  /// The answer: of a miss, nothing but the face NO_INDEX.
  RayHit hit() const { return best.face == NO_INDEX ? RayHit() : best; }

  /// Asks RayTest for a triangle. Says whether that is a hit and, where any will do, the end.
  bool tryTriangle(const Bvh& bvh, const RayOptions& options, std::size_t triangle)
  {
    RayHit found;
    if (!meets(test, bvh.corners().data() + 9 * triangle, options.back_faces, &found.distance,
               &found.barycentric)) {
      return false;
    }
    const std::uint32_t face = bvh.faces()[triangle];
    if (!options.mask.empty() && options.mask[face] == 0) {
      return false;
    }
    if (found.distance < best.distance || (found.distance == best.distance && face < best.face)) {
      found.face = face;
      best = found;
      limit = beam.depth(best.distance);
    }
    return true;
  }

  RayTest test;
  Beam beam;
  RayHit best;  // distance: the maximum, as long as there is none
  float limit;  // depth of hits that count
};

/// Throws std::invalid_argument for a mask that is neither empty nor one per face.
void checkMask(const Bvh& bvh, ArrayView<std::uint8_t> mask);

/// A subtree to be searched: BvhNode::child and count of it, and the depth where the beam enters.
struct RayTask
{
  std::uint32_t child;
  std::uint32_t count;
  float depth;
};

/// Searches a leaf. ANY: stops at any hit, and says so.
template <bool ANY>
bool searchLeaf(const Bvh& bvh, const RayOptions& options, std::size_t first, unsigned count,
                RaySearch& search)
{
  const TriangleFilter filter(bvh.corners().data() + 9 * first);
  for (unsigned hits = filter(search.beam) & ((1u << count) - 1); hits != 0; hits &= hits - 1) {
    if (search.tryTriangle(bvh, options, first + lowestBit(hits)) && ANY) {
      return true;
    }
  }
  return false;
}

/// Asks the memory for what a task will read.
inline void prefetch(const Bvh& bvh, std::uint32_t child)
{
  const char* const from =
      isLeaf(child) ? reinterpret_cast<const char*>(bvh.corners().data() + 9 * (child & ~BVH_LEAF))
                    : reinterpret_cast<const char*>(bvh.nodes().data() + child);
  __builtin_prefetch(from);
  __builtin_prefetch(from + 64);
}

/// Adds the children of a node that are entered to a stack, the nearest last. Returns its size.
inline std::size_t pushChildren(const Bvh& bvh, const BvhNode& node, const BoxHits& boxes,
                                RayTask* stack, std::size_t size)
{
  alignas(16) float depths[BVH_WIDTH];
  std::memcpy(depths, &boxes.depths, sizeof(depths));
  const std::size_t first = size;
  for (unsigned hits = boxes.hits; hits != 0; hits &= hits - 1) {
    const unsigned k = lowestBit(hits);
    prefetch(bvh, node.child[k]);
    std::size_t place = size++;
    for (; place > first && stack[place - 1].depth < depths[k]; --place) {
      stack[place] = stack[place - 1];
    }
    stack[place] = {node.child[k], node.count[k], depths[k]};
  }
  return size;
}

/// Searches a subtree, from near to far. ANY: stops at any hit, and says so.
template <bool ANY>
bool searchTree(const Bvh& bvh, const RayOptions& options, RayTask root, RaySearch& search)
{
  RayTask stack[BVH_STACK];
  std::size_t size = 0;
  const BvhNode* const nodes = bvh.nodes().data();
  RayTask task = root;
  for (;;) {
    while (!isLeaf(task.child)) {
      const BvhNode& node = nodes[task.child];
      const BoxHits boxes = enterBoxes(search.beam, node, search.limit);
      if (boxes.hits == 0) {
        task.count = 0;  // nothing is left of it
        task.child = BVH_NO_CHILD;
      } else if ((boxes.hits & (boxes.hits - 1)) == 0) {
        const unsigned k = lowestBit(boxes.hits);
        task = {node.child[k], node.count[k], 0.0f};
      } else {
        size = pushChildren(bvh, node, boxes, stack, size);
        task = stack[--size];
      }
    }
    if (task.count > 0 &&
        searchLeaf<ANY>(bvh, options, task.child & ~BVH_LEAF, task.count, search) && ANY) {
      return true;
    }
    do {
      if (size == 0) {
        return false;
      }
      task = stack[--size];
    } while (task.depth > search.limit);
  }
}

/// Answers for one ray, whatever its reach. ANY: stops at any hit.
template <bool ANY>
void searchAll(const Bvh& bvh, const RayOptions& options, RaySearch& search)
{
  if (search.beam.reach == Beam::Reach::FLOATS) {
    searchTree<ANY>(bvh, options, {0, 0, 0.0f}, search);
  } else if (search.beam.reach == Beam::Reach::ALL) {
    for (std::size_t i = 0; i < bvh.faceCount(); ++i) {
      if (search.tryTriangle(bvh, options, i) && ANY) {
        return;
      }
    }
  }
}

}  // namespace mesh_map
