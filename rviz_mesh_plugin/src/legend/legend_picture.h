#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <QImage>

#include "base/layer_info.h"
#include "coloring/cost_coloring.h"

namespace rviz_mesh_plugin {

/// A labelled position on a scale.
struct ScaleTick
{
  double value = 0.0;
  double position = 0.0;  ///< 0 at the lesser limit, 1 at the greater one
  std::string label;
};

/// At most @a most ticks, ascending: multiples of 1, 2 or 5 times a power of ten; on a logarithmic
/// scale of more than a decade powers of ten, or 1, 2 and 5 times these. Equal limits have one
/// tick, in the middle.
/// @param most at least 2
std::vector<ScaleTick> scaleTicks(const CostColoring& coloring, const CostLimits& limits,
                                  std::size_t most);

/// What a legend tells.
struct LegendContent
{
  std::string layer;
  std::string unit;  ///< empty where it is not known
  CostColoring coloring;
  CostLimits limits;     ///< that the scale spans, as limitsOf() gives them
  LayerInfo info{};      ///< threshold and cost limit are marked on the scale
  bool of_costs = true;  ///< whether there may be lethal and unknown ones
};

bool operator==(const LegendContent& a, const LegendContent& b);

/// The height that a legend has where there is room for it, in pixels.
constexpr int LEGEND_HEIGHT = 300;

/// Where there is less room, there is no legend.
constexpr int LEAST_LEGEND_HEIGHT = 120;

/// Draws a color bar (the greatest cost at the top) with ticks, the name of the layer above and the
/// colors of lethal and unknown costs below it, on translucent black: readable before any
/// background. GUI thread only; needs a QGuiApplication, which has the fonts.
/// @param height in pixels of the screen where @a pixel_ratio is 1
/// @return format ARGB32, @a height * @a pixel_ratio rows
QImage drawLegend(const LegendContent& content, int height, double pixel_ratio = 1.0);

}  // namespace rviz_mesh_plugin
