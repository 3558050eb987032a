#pragma once

#include <vector>

#include "rviz_mesh_plugin/cost_summary.h"
#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

/// Numbers and names as in .rviz files (property "Color Scale").
enum class ColorScale
{
  RAINBOW = 0,   ///< magenta, blue, cyan, green, yellow, red
  RED_GREEN = 1  ///< green, yellow, red
};

/// The color of vertices whose cost is unknown (NaN): grey, which neither scale contains.
constexpr Rgba8 UNKNOWN_COST_COLOR{128, 128, 128, 255};

/// The color at @a position of a scale; what is outside 0..1 gets the color of the nearer end.
Rgba8 scaleColor(ColorScale scale, float position);

/// The color of one cost. +inf gets the last color of the scale, NaN UNKNOWN_COST_COLOR. Where both
/// limits are equal, costs up to them get the first color and greater ones the last; where the
/// lower limit is above the upper one, the scale runs backwards.
Rgba8 costColor(ColorScale scale, const CostLimits& limits, float cost);

/// costColor() of each cost.
std::vector<Rgba8> costColors(ColorScale scale, const CostLimits& limits,
                              const std::vector<float>& costs);

}  // namespace rviz_mesh_plugin
