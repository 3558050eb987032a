#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace rviz_mesh_plugin {

/// A box along the axes, in meters.
struct Bounds
{
  std::array<float, 3> lower{};
  std::array<float, 3> upper{};

  /// Encloses nothing yet.
  static Bounds none()
  {
    Bounds bounds;
    bounds.lower.fill(std::numeric_limits<float>::max());
    bounds.upper.fill(std::numeric_limits<float>::lowest());
    return bounds;
  }

  void enclose(const Bounds& other)
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], other.lower[axis]);
      upper[axis] = std::max(upper[axis], other.upper[axis]);
    }
  }
  void enclose(const std::array<float, 3>& position) { enclose(Bounds{position, position}); }

  std::array<float, 3> sides() const
  {
    return {upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]};
  }
};

}  // namespace rviz_mesh_plugin
