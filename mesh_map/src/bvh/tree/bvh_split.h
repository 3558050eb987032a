#pragma once

#include <mesh_map/bvh/tree/bvh_node.h>

#include <cstdint>
#include <utility>

#include "base/float_bits.h"
#include "bvh/tree/float_box.h"

namespace mesh_map {

/// What is divided among nodes: a triangle or a cluster of some. The fourth floats hold its number
/// and how many triangles it has.
struct BvhItem : FloatBox
{
  BvhItem() = default;
  BvhItem(const FloatBox& box, std::uint32_t index, std::uint32_t count) : FloatBox(box)
  {
    lower[3] = floatOf(index);
    upper[3] = floatOf(count);
  }

  std::uint32_t index() const { return bitsOf(lower[3]); }
  std::uint32_t count() const { return bitsOf(upper[3]); }
};

/// Some of the items.
struct BvhSpan
{
  std::uint32_t begin, end;  ///< items
  std::uint32_t buffer;      ///< which of the two buffers holds them
  std::uint32_t count;       ///< triangles
  FloatBox box;

  std::uint32_t items() const { return end - begin; }
};

/// Full leaves that so many triangles fill.
inline std::uint32_t leafBlocks(std::uint32_t count)
{
  return (count + BVH_LEAF_SIZE - 1) / BVH_LEAF_SIZE;
}

/// Divides items so that rays meet as little as possible (surface area heuristic: I. Wald: On fast
/// Construction of SAH-based Bounding Volume Hierarchies, 2007), or at least evenly. A span of the
/// one buffer is divided into the other one.
class BvhSplitter
{
 public:
  /// Buffers of as many items as the spans have.
  BvhSplitter(BvhItem* items, BvhItem* others) : buffers_{items, others} {}

  /// Two spans, both with items, of one with two items or more.
  std::pair<BvhSpan, BvhSpan> split(const BvhSpan& span) const;

  /// The same, with half of the triangles each up to one leaf. Items have to be triangles.
  std::pair<BvhSpan, BvhSpan> halve(const BvhSpan& span) const;

  const BvhItem* items(const BvhSpan& span) const { return buffers_[span.buffer] + span.begin; }

 private:
  template <unsigned BINS>
  std::pair<BvhSpan, BvhSpan> binnedSplit(const BvhSpan& span, const FloatBox& centers) const;
  BvhSpan measured(std::uint32_t begin, std::uint32_t end, std::uint32_t buffer) const;

  BvhItem* buffers_[2];
};

}  // namespace mesh_map
