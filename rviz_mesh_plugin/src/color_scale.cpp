#include "rviz_mesh_plugin/color_scale.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rviz_mesh_plugin {
namespace {

using Rgb = std::array<float, 3>;

constexpr std::array<Rgb, 6> RAINBOW_STOPS{{{1.0f, 0.0f, 1.0f},
                                            {0.0f, 0.0f, 1.0f},
                                            {0.0f, 1.0f, 1.0f},
                                            {0.0f, 1.0f, 0.0f},
                                            {1.0f, 1.0f, 0.0f},
                                            {1.0f, 0.0f, 0.0f}}};
constexpr std::array<Rgb, 3> RED_GREEN_STOPS{
    {{0.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f}}};

std::uint8_t toByte(float value)
{
  return static_cast<std::uint8_t>(value * 255.0f + 0.5f);
}

/// Piecewise linear between equally spaced stops; @a position in 0..1.
template <std::size_t COUNT>
Rgba8 interpolate(const std::array<Rgb, COUNT>& stops, float position)
{
  const float scaled = position * static_cast<float>(COUNT - 1);
  const auto first = std::min(static_cast<std::size_t>(scaled), COUNT - 2);
  const float part = scaled - static_cast<float>(first);
  const Rgb& a = stops[first];
  const Rgb& b = stops[first + 1];
  return {toByte(a[0] + part * (b[0] - a[0])), toByte(a[1] + part * (b[1] - a[1])),
          toByte(a[2] + part * (b[2] - a[2])), 255};
}

}  // namespace

Rgba8 scaleColor(ColorScale scale, float position)
{
  position = std::min(std::max(position, 0.0f), 1.0f);
  return scale == ColorScale::RED_GREEN ? interpolate(RED_GREEN_STOPS, position)
                                        : interpolate(RAINBOW_STOPS, position);
}

Rgba8 costColor(ColorScale scale, const CostLimits& limits, float cost)
{
  if (std::isnan(cost)) {
    return UNKNOWN_COST_COLOR;
  }
  if (std::isinf(cost)) {
    return scaleColor(scale, cost > 0.0f ? 1.0f : 0.0f);
  }
  if (limits.lower == limits.upper) {
    return scaleColor(scale, cost > limits.upper ? 1.0f : 0.0f);
  }
  // In double, since the span of two floats may be more than a float holds.
  const double span = static_cast<double>(limits.upper) - limits.lower;
  return scaleColor(scale, static_cast<float>((static_cast<double>(cost) - limits.lower) / span));
}

std::vector<Rgba8> costColors(ColorScale scale, const CostLimits& limits,
                              const std::vector<float>& costs)
{
  std::vector<Rgba8> colors(costs.size());
  std::transform(costs.begin(), costs.end(), colors.begin(),
                 [&](float cost) { return costColor(scale, limits, cost); });
  return colors;
}

}  // namespace rviz_mesh_plugin
