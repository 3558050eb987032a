#pragma once

#include <cstddef>
#include <vector>

#include "base/cost_summary.h"
#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Numbers and names as in .rviz files (property "Color Scale").
enum class ColorScale
{
  RAINBOW = 0,    ///< magenta, blue, cyan, green, yellow, red
  RED_GREEN = 1,  ///< green, yellow, red
  VIRIDIS = 2,    ///< this and the following are those of matplotlib
  PLASMA = 3,
  INFERNO = 4,
  MAGMA = 5,
  CIVIDIS = 6,
  TURBO = 7,
  JET = 8,
  COOLWARM = 9,
  GREY = 10  ///< black to white
};

/// The scales with their names, in the order of their numbers.
struct NamedColorScale
{
  ColorScale scale;
  const char* name;
};
const std::vector<NamedColorScale>& colorScales();

/// The color of vertices whose cost is unknown (NaN), where none is chosen. As that of lethal ones,
/// it is farther than 20 (CIELAB) from every color of every scale; mesh_tool render has the same.
constexpr Rgba8 UNKNOWN_COST_COLOR{104, 78, 40, 255};

/// The color of vertices whose cost is +inf or lethal, where none is chosen.
constexpr Rgba8 LETHAL_COST_COLOR{255, 20, 147, 255};

/// The color at @a position of a scale, linear between its stops; what is outside 0..1 gets the
/// color of the nearer end.
Rgba8 scaleColor(ColorScale scale, float position);

/// Colors of a scale for many positions: each differs from scaleColor() by at most one step of a
/// channel, and not at all at the stops.
class ColorTable
{
 public:
  explicit ColorTable(ColorScale scale, bool inverted = false);

  /// @param position NaN is not allowed; clamped to 0..1
  Rgba8 at(float position) const
  {
    position = position < 0.0f ? 0.0f : position > 1.0f ? 1.0f : position;
    return colors_[static_cast<std::size_t>(position * STEPS + 0.5f)];
  }

 private:
  /// A multiple of the distances between stops of all scales: 5, 2 and 255.
  static constexpr std::size_t STEPS = 4080;

  std::vector<Rgba8> colors_;
};

}  // namespace rviz_mesh_plugin
