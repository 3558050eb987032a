#pragma once

#include <array>
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
