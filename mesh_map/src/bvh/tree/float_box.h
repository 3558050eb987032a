#pragma once

#include <limits>

#include "base/simd.h"

namespace mesh_map {

/// Boxes use three of four floats.
inline Floats4 load3(const float* values)
{
  return Floats4{values[0], values[1], values[2], 0.0f};
}

/// An axis-parallel box. An empty one is inverted.
struct FloatBox
{
  Floats4 lower = all4(std::numeric_limits<float>::infinity());
  Floats4 upper = all4(-std::numeric_limits<float>::infinity());

  void add(const FloatBox& other)
  {
    lower = minimum(other.lower, lower);
    upper = maximum(other.upper, upper);
  }
  void add(Floats4 point)
  {
    lower = minimum(point, lower);
    upper = maximum(point, upper);
  }
};

/// Half the surface.
inline float halfArea(const FloatBox& box)
{
  const Floats4 size = box.upper - box.lower;
  return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

}  // namespace mesh_map
