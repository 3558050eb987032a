#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "reconstruction/key_index.h"

namespace mesh_map {

using Vector3f = std::array<float, 3>;

/// The cells of a grid of size 1 that a straight line passes, one beside the other (J. Amanatides
/// and A. Woo: A Fast Voxel Traversal Algorithm for Ray Tracing, 1987).
class CellWalk
{
 public:
  /// From a to b, within the limits of GridPlace.
  CellWalk(const Vector3f& a, const Vector3f& b)
  {
    const auto cellOf = [](float at) {
      const auto cell = static_cast<std::int32_t>(at);
      return cell - (at < static_cast<float>(cell) ? 1 : 0);
    };
    const GridPlace first = {cellOf(a[0]), cellOf(a[1]), cellOf(a[2])};
    steps_ = static_cast<std::size_t>(std::abs(cellOf(b[0]) - first.x) +
                                      std::abs(cellOf(b[1]) - first.y) +
                                      std::abs(cellOf(b[2]) - first.z));
    key_ = static_cast<std::int64_t>(first.key());
    x_ = Axis(a[0], b[0], first.x, cellOf(b[0]), 1);
    y_ = Axis(a[1], b[1], first.y, cellOf(b[1]), std::int64_t{1} << 21);
    z_ = Axis(a[2], b[2], first.z, cellOf(b[2]), std::int64_t{1} << 42);
  }

  std::size_t count() const { return steps_ + 1; }

  /// Calls visit(key of its GridPlace) for each.
  template <class Visit>
  void each(const Visit& visit) const
  {
    std::int64_t x = x_.next, y = y_.next, z = z_.next, key = key_;
    for (std::size_t left = steps_;; --left) {
      visit(static_cast<std::uint64_t>(key));
      if (left == 0) {
        return;
      }
      // Masks in place of branches, for which axis comes next cannot be foretold.
      const std::int64_t x_before_y = -std::int64_t{x < y}, x_before_z = -std::int64_t{x < z};
      const std::int64_t y_before_z = -std::int64_t{y < z};
      const std::int64_t is_x = x_before_y & x_before_z, is_y = ~x_before_y & y_before_z;
      const std::int64_t is_z = ~(is_x | is_y);
      x += x_.width & is_x;
      y += y_.width & is_y;
      z += z_.width & is_z;
      key += (x_.ahead & is_x) + (y_.ahead & is_y) + (z_.ahead & is_z);
    }
  }

 private:
  /// Where the line enters cells along an axis, as whole numbers: of 0 at a to UNITS at b.
  struct Axis
  {
    static constexpr float UNITS = 1099511627776.0f, WIDEST = 2 * GridPlace::LIMIT;
    static constexpr std::int64_t NEVER = std::int64_t{1} << 62;

    Axis() = default;
    Axis(float a, float b, std::int32_t first, std::int32_t last, std::int64_t one)
    {
      const float way = b - a, wide = std::min(1 / std::abs(way), WIDEST) * UNITS;
      const float before = a - static_cast<float>(first);
      const float border = way < 0 ? before : 1 - before;
      width = static_cast<std::int64_t>(wide);
      next = first == last ? NEVER : static_cast<std::int64_t>(border * wide);
      ahead = way < 0 ? -one : one;
    }

    std::int64_t next, width, ahead;  ///< the next cell's; of a cell; what its key is larger
  };

  Axis x_, y_, z_;
  std::int64_t key_;
  std::size_t steps_;
};

}  // namespace mesh_map
