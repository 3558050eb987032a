#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/bounds.h"

namespace rviz_mesh_plugin {

/// What is seen of a mesh that is cut: what lies in a box along the axes of the mesh, its border
/// included, in meters. An infinite side is no limit, and at first there is none.
struct Section : Bounds
{
  Section()
  {
    lower.fill(-std::numeric_limits<float>::infinity());
    upper.fill(std::numeric_limits<float>::infinity());
  }

  /// Whether there is a limit.
  bool cuts() const { return lower != Section().lower || upper != Section().upper; }

  template <class Number>
  bool contains(const std::array<Number, 3>& point) const
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(lower[axis] <= point[axis] && point[axis] <= upper[axis])) {
        return false;
      }
    }
    return true;
  }

  /// A little larger on all sides, as rounding is not to decide on what lies in a limit: a floor in
  /// its plane would be drawn, or met by rays, in part.
  Bounds widened() const
  {
    Bounds bounds;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.lower[axis] = outside(lower[axis], -1.0f);
      bounds.upper[axis] = outside(upper[axis], 1.0f);
    }
    return bounds;
  }

  bool touches(const Bounds& bounds) const
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(lower[axis] <= bounds.upper[axis] && bounds.lower[axis] <= upper[axis] &&
            lower[axis] <= upper[axis])) {
        return false;
      }
    }
    return true;
  }

  bool contains(const Bounds& bounds) const
  {
    return contains(bounds.lower) && contains(bounds.upper);
  }

 private:
  static float outside(float limit, float sign)
  {
    constexpr float STEPS = 4.0f, LEAST = 1e-6f;
    const float finite =
        std::clamp(limit, std::numeric_limits<float>::lowest(), std::numeric_limits<float>::max());
    const float margin = STEPS * std::numeric_limits<float>::epsilon() * std::fabs(finite) + LEAST;
    return std::isfinite(limit) ? finite + sign * margin : finite;
  }
};

inline bool operator==(const Section& a, const Section& b)
{
  return a.lower == b.lower && a.upper == b.upper;
}
inline bool operator!=(const Section& a, const Section& b)
{
  return !(a == b);
}

}  // namespace rviz_mesh_plugin
