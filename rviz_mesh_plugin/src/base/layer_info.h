#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <string>

namespace rviz_mesh_plugin {

/// What the values of a cost layer mean, as its map says it; without that, only +inf is lethal.
struct LayerInfo
{
  enum Comparison
  {
    NONE,      ///< beside +inf no value is lethal
    ABOVE,     ///< values above the threshold are
    AT_LEAST,  ///< the threshold is, too
    OTHER      ///< which are does not follow from the values
  };

  std::string layer_type;           ///< its plugin; empty where it is none, as Combined Costs
  std::string unit;                 ///< empty where it is not known
  std::string infinity = "lethal";  ///< what +inf means
  Comparison comparison = NONE;
  float threshold = std::numeric_limits<float>::quiet_NaN();
  float cost_limit = std::numeric_limits<float>::quiet_NaN();  ///< of planners; NaN: none
  std::size_t lethal = 0;                                      ///< OTHER: how many vertices

  /// Whether values beside +inf are lethal.
  bool hasThreshold() const;
  /// The least value that is lethal; +inf where no other one is.
  float leastLethal() const;
  bool isLethal(float value) const { return value >= leastLethal(); }
};

bool operator==(const LayerInfo& a, const LayerInfo& b);

/// "lethal above 0.3 rad"; empty where that follows from no threshold.
std::string lethalRule(const LayerInfo& info);

using LayerInfos = std::map<std::string, LayerInfo>;  ///< by the names of layers

}  // namespace rviz_mesh_plugin
