#include "bvh_morton.h"

#include <cmath>

namespace mesh_map {

MortonCurve::MortonCurve(const FloatBox& box)
    : lower_(box.lower), scale_(allOf(0.0f)), highest_(allOf(0.0f))
{
  // From the highest bit on, each one halves the cells along the axis where they are the longest.
  float size[3];
  unsigned bits[3] = {};
  int axis_of_bit[BITS];
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = box.upper[axis] - box.lower[axis];
    size[axis] = std::isfinite(extent) && extent > 0.0f ? extent : 0.0f;
  }
  for (int& axis : axis_of_bit) {
    axis = size[1] > size[0] ? 1 : 0;
    axis = size[2] > size[axis] ? 2 : axis;
    if (!(size[axis] > 0.0f)) {
      axis = -1;
    } else if (++bits[axis] == BITS_PER_AXIS) {
      size[axis] = 0.0f;
    } else {
      size[axis] *= 0.5f;
    }
  }
  unsigned left[3] = {bits[0], bits[1], bits[2]};
  for (unsigned bit = 0; bit < BITS; ++bit) {
    const int axis = axis_of_bit[bit];
    if (axis >= 0) {
      const unsigned from = --left[axis];
      const std::uint32_t to = std::uint32_t{1} << (BITS - 1 - bit);
      for (unsigned value = 0; value < 256; ++value) {
        if (((value >> (from % 8)) & 1) != 0) {
          spread_[2 * static_cast<unsigned>(axis) + from / 8][value] |= to;
        }
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const float cells = std::exp2(static_cast<float>(bits[axis]));
    const float scale = cells / (box.upper[axis] - box.lower[axis]);
    if (bits[axis] > 0 && std::isfinite(scale)) {
      scale_[axis] = scale;
      highest_[axis] = cells - 1.0f;
    }
  }
}

}  // namespace mesh_map
