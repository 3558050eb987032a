#pragma once

#include <cstddef>
#include <vector>

namespace rviz_mesh_plugin {

/// The costs that get the first and the last color of a scale.
struct CostLimits
{
  float lower = 0.0f;
  float upper = 1.0f;
};

/// What a cost layer consists of.
struct CostSummary
{
  CostLimits limits;        ///< least and greatest finite cost; 0 and 0 where there is none
  std::size_t finite = 0;   ///< values that are a finite cost
  std::size_t lethal = 0;   ///< +inf
  std::size_t unknown = 0;  ///< NaN
};

CostSummary summarizeCosts(const std::vector<float>& costs);

}  // namespace rviz_mesh_plugin
