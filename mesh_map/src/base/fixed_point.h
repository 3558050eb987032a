#pragma once

#include <cstddef>
#include <cstdint>

namespace mesh_map {

/// Angles of 0 to pi as whole numbers: their sum does not depend on the order.
constexpr double ANGLE_UNITS = 1u << 30;  // per radian

/// A value that is not negative, rounded to the nearest; the largest number where it does not fit
/// or is NaN.
inline std::uint32_t toFixed(double value, double units)
{
  constexpr double largest = 4294967295.0;
  const double scaled = value * units + 0.5;
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(scaled < largest ? scaled : largest));
}

/// 0 of nothing.
inline float meanOfFixed(std::uint64_t sum, double units, std::size_t count)
{
  return count == 0
             ? 0.0f
             : static_cast<float>(static_cast<double>(sum) / (units * static_cast<double>(count)));
}

}  // namespace mesh_map
