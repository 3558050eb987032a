#pragma once

#include <limits>
#include <string>

#include "base/cost_summary.h"
#include "base/mesh_data.h"
#include "coloring/color_scale.h"
#include "coloring/color_source.h"

namespace rviz_mesh_plugin {

/// How costs become colors.
struct CostColoring
{
  ColorScale scale = ColorScale::RAINBOW;
  bool inverted = false;
  bool logarithmic = false;
  bool custom_limits = false;
  CostLimits limits;     ///< where custom
  float clipped = 0.0f;  ///< percent of the finite costs left out at each end of automatic limits
  Rgba8 lethal = LETHAL_COST_COLOR;    ///< of +inf and what is lethal
  Rgba8 unknown = UNKNOWN_COST_COLOR;  ///< of NaN
  bool mark_lethal = true;  ///< whether costs that the layer calls lethal have that color, too
  float least_lethal = std::numeric_limits<float>::infinity();  ///< from which on it does
  bool mark_outside = false;
  Rgba8 below{0, 0, 0, 255};  ///< of costs outside the limits, where marked; else the scale's ends
  Rgba8 above{255, 255, 255, 255};
};

bool operator==(const CostColoring& a, const CostColoring& b);
inline bool operator!=(const CostColoring& a, const CostColoring& b)
{
  return !(a == b);
}

/// The limits that the scale spans for a layer.
///
/// Automatic ones are the least and the greatest finite cost, or the percentiles inside of which
/// the share `clipped` leaves the rest; where these percentiles are equal (a layer that is nearly
/// constant) nothing is clipped. Where the scale is logarithmic and a limit is not above 0, the
/// least cost above 0 takes its place; where no cost is above 0 the limits stay, and the scale is
/// linear.
CostLimits limitsOf(const CostColoring& coloring, const CostSummary& summary);

/// Whether the scale is logarithmic between these limits: where asked for, and both are above 0.
bool isLogarithmic(const CostColoring& coloring, const CostLimits& limits);

/// What is done with costs that cannot be shown as asked, as a part of a sentence: "the scale is
/// linear, since no cost is above 0". Empty where there is nothing to say.
std::string coloringNote(const CostColoring& coloring, const CostSummary& summary);

/// The colors of a layer for MeshVisual::setColors(): those of the scale, to within one step of a
/// channel. Takes about 5 ms per million costs.
ColorSource colorSource(const CostLayerConstPtr& layer, const CostColoring& coloring);

/// The same for the heights (z, in the frame of the mesh) of its vertices.
/// @param coloring with custom limits
ColorSource heightSource(const MeshDataConstPtr& mesh, const CostColoring& coloring);

}  // namespace rviz_mesh_plugin
