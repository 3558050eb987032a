#pragma once

#include <mesh_map/bvh/tree/bvh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/simd.h"
#include "base/vector3.h"

namespace mesh_map {

/// A box in the local coordinates of a hierarchy, rounded outwards.
class SearchBox
{
 public:
  /// `lower` and `upper` are in the coordinates of the mesh.
  SearchBox(const Bvh& bvh, const Vector3& lower, const Vector3& upper)
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower_[axis] = all4(-outwards(double{bvh.center()[axis]} - lower[axis]));
      upper_[axis] = all4(outwards(upper[axis] - double{bvh.center()[axis]}));
    }
  }

  /// Bit k: the box of child k touches it.
  unsigned touched(const BvhNode& node) const
  {
    Ints4 apart = {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      apart |= (load4(node.lower[axis]) > upper_[axis]) | (load4(node.upper[axis]) < lower_[axis]);
    }
    return ~bits(apart) & 0xFu;
  }

 private:
  /// A float that is not smaller. Infinity stays what it is.
  static float outwards(double value)
  {
    constexpr double largest = std::numeric_limits<float>::max();
    return value > largest ? std::numeric_limits<float>::infinity()
                           : std::nextafter(static_cast<float>(std::max(-largest, value)),
                                            std::numeric_limits<float>::infinity());
  }

  std::array<Floats4, 3> lower_, upper_;
};

/// Calls visit(i) for the triangles, in the order of the leaves, of all leaves that touch a box,
/// until it returns true. Whether it did.
template <class Visit>
bool searchBox(const Bvh& bvh, const Vector3& lower, const Vector3& upper, const Visit& visit)
{
  struct Subtree
  {
    std::uint32_t child, count;
  };
  const SearchBox box(bvh, lower, upper);
  std::array<Subtree, BVH_STACK> stack;
  std::size_t size = 0;
  stack[size++] = {0, static_cast<std::uint32_t>(bvh.faceCount())};
  while (size > 0) {
    const Subtree tree = stack[--size];
    if (isLeaf(tree.child)) {
      const std::size_t first = tree.child & ~BVH_LEAF;
      for (std::size_t i = first; i < first + tree.count; ++i) {
        if (visit(i)) {
          return true;
        }
      }
      continue;
    }
    const BvhNode& node = bvh.nodes()[tree.child];
    for (unsigned hits = box.touched(node); hits != 0; hits &= hits - 1) {
      const unsigned k = lowestBit(hits);
      if (node.count[k] > 0) {
        stack[size++] = {node.child[k], node.count[k]};
      }
    }
  }
  return false;
}

}  // namespace mesh_map
