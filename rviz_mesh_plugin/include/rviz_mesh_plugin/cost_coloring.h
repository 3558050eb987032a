#pragma once

#include "rviz_mesh_plugin/color_scale.h"
#include "rviz_mesh_plugin/cost_summary.h"
#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/mesh_visual.h"

namespace rviz_mesh_plugin {

/// How costs become colors.
struct CostColoring
{
  ColorScale scale = ColorScale::RAINBOW;
  bool inverted = false;
  bool logarithmic = false;
  bool custom_limits = false;
  CostLimits limits;      ///< where custom
  float clipped = 0.0f;   ///< percent of the finite costs left out at each end of automatic limits
  Rgba8 lethal, unknown;  ///< colors of +inf and NaN
  bool mark_outside = false;
  Rgba8 below, above;  ///< of costs outside the limits, where marked; else the scale's ends
};

/// The limits that the scale spans for a layer.
CostLimits limitsOf(const CostColoring& coloring, const CostSummary& summary);

/// The colors of a layer for MeshVisual::setColors().
ColorSource colorSource(const CostLayerConstPtr& layer, const CostColoring& coloring);

}  // namespace rviz_mesh_plugin
