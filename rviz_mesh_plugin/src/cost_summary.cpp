#include "rviz_mesh_plugin/cost_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rviz_mesh_plugin {

CostSummary summarizeCosts(const std::vector<float>& costs)
{
  CostSummary summary;
  float lower = std::numeric_limits<float>::max();
  float upper = std::numeric_limits<float>::lowest();
  for (const float cost : costs) {
    if (std::isfinite(cost)) {
      lower = std::min(lower, cost);
      upper = std::max(upper, cost);
      ++summary.finite;
    } else if (std::isnan(cost)) {
      ++summary.unknown;
    } else {
      ++summary.lethal;
    }
  }
  summary.limits = summary.finite > 0 ? CostLimits{lower, upper} : CostLimits{0.0f, 0.0f};
  return summary;
}

}  // namespace rviz_mesh_plugin
