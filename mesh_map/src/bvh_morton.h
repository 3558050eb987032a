#ifndef MESH_MAP_SRC_BVH_MORTON_H
#define MESH_MAP_SRC_BVH_MORTON_H

#include <array>
#include <cstdint>

#include "float_box.h"

namespace mesh_map {

/// Numbers points so that those with nearby numbers are near each other: a Morton curve of 32 bits
/// that gives each axis as many of them as its extent deserves. Points outside of the box get the
/// numbers of its border.
class MortonCurve
{
 public:
  static constexpr unsigned BITS = 32;

  explicit MortonCurve(const FloatBox& box);

  std::uint32_t operator()(Float4 point) const
  {
    // NaN (of infinite numbers) becomes 0.
    Float4 cell = (point - lower_) * scale_;
    cell = minimum(maximum(cell, allOf(0.0f)), highest_);
    const auto x = static_cast<unsigned>(cell[0]), y = static_cast<unsigned>(cell[1]),
               z = static_cast<unsigned>(cell[2]);
    return spread_[0][x & 0xFF] | spread_[1][x >> 8] | spread_[2][y & 0xFF] | spread_[3][y >> 8] |
           spread_[4][z & 0xFF] | spread_[5][z >> 8];
  }

 private:
  static constexpr unsigned BITS_PER_AXIS = 16;

  Float4 lower_, scale_, highest_;
  std::array<std::array<std::uint32_t, 256>, 6> spread_{};  // per axis: low byte, high byte
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_BVH_MORTON_H
