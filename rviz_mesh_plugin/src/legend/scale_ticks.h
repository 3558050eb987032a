#pragma once

#include <cstddef>
#include <string>
#include <vector>

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

}  // namespace rviz_mesh_plugin
