#include "base/layer_info.h"

#include <cmath>
#include <cstdio>
#include <tuple>

namespace rviz_mesh_plugin {

bool LayerInfo::hasThreshold() const
{
  return (comparison == ABOVE || comparison == AT_LEAST) && std::isfinite(threshold);
}

float LayerInfo::leastLethal() const
{
  constexpr float INFINITE = std::numeric_limits<float>::infinity();
  if (!hasThreshold()) {
    return INFINITE;
  }
  return comparison == ABOVE ? std::nextafter(threshold, INFINITE) : threshold;
}

bool operator==(const LayerInfo& a, const LayerInfo& b)
{
  // Numbers that are NaN are equal.
  const auto number = [](float value) { return std::isnan(value) ? -1.0f : value; };
  const auto all = [&](const LayerInfo& info) {
    return std::make_tuple(std::cref(info.layer_type), std::cref(info.unit),
                           std::cref(info.infinity), info.comparison, number(info.threshold),
                           number(info.cost_limit), info.lethal);
  };
  return all(a) == all(b);
}

std::string lethalRule(const LayerInfo& info)
{
  if (!info.hasThreshold()) {
    return std::string();
  }
  char number[32];
  std::snprintf(number, sizeof(number), "%.4g", static_cast<double>(info.threshold));
  return (info.comparison == LayerInfo::ABOVE ? "lethal above " : "lethal from ") +
         std::string(number) + (info.unit.empty() ? "" : " " + info.unit);
}

}  // namespace rviz_mesh_plugin
