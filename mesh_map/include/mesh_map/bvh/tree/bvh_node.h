#pragma once

#include <cstddef>
#include <cstdint>

namespace mesh_map {

/// Children of a node.
constexpr std::size_t BVH_WIDTH = 4;

/// Triangles of a leaf at most.
constexpr std::uint32_t BVH_LEAF_SIZE = 4;

/// Nodes on the way from the root to a leaf at most, whatever the mesh.
constexpr std::size_t BVH_DEPTH = 42;

/// Entries of a stack that no traversal overflows: each node leaves all its children but one there.
constexpr std::size_t BVH_STACK = (BVH_WIDTH - 1) * BVH_DEPTH + 2;

/// Bit of BvhNode::child: the child is a leaf.
constexpr std::uint32_t BVH_LEAF = 0x80000000u;

/// BvhNode::child of a slot without a child. Its box is inverted (+inf to -inf), its count 0.
constexpr std::uint32_t BVH_NO_CHILD = 0xFFFFFFFFu;

/// Four children of a bounding volume hierarchy with their boxes, axis by axis, so that they are
/// tested side by side. OpenCL reads it verbatim as eight float4 (the last two are uint4).
///
/// Boxes are in local coordinates: relative to Bvh::center(), rounded outwards. They touch or
/// contain their triangles, and no box has a NaN (but an infinite side where a coordinate is next
/// to the largest float).
///
/// Triangles lie in the order of the leaves: those below child k are the count[k] ones after those
/// of the children before k.
struct alignas(64) BvhNode
{
  float lower[3][BVH_WIDTH];
  float upper[3][BVH_WIDTH];
  std::uint32_t child[BVH_WIDTH];  ///< node index (above that of the parent), or BVH_LEAF | first
                                   ///< triangle, or BVH_NO_CHILD
  std::uint32_t count[BVH_WIDTH];  ///< triangles below
};
static_assert(sizeof(BvhNode) == 128, "OpenCL relies on it");

inline bool isLeaf(std::uint32_t child)
{
  return (child & BVH_LEAF) != 0;  // true for BVH_NO_CHILD, too: a leaf without triangles
}

}  // namespace mesh_map
