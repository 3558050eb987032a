#include "coloring/cost_coloring.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
#include <tuple>

namespace rviz_mesh_plugin {
namespace {

/// Where custom limits leave nothing else: the lower limit of a logarithmic scale is at most this
/// share of the upper one.
constexpr float LEAST_SHARE = 1e-3f;

/// Where costs (no NaN) lie between the limits: 0 at the lower, 1 at the upper one and beyond.
/// Where both are equal, costs up to them are at 0 and greater ones at 1; where the lower limit is
/// above the upper one, the scale runs backwards.
class Positions
{
 public:
  Positions(const CostColoring& coloring, const CostLimits& limits)
      : limits_(limits), logarithmic_(isLogarithmic(coloring, limits))
  {
    // In double, since the span of two floats may be more than a float holds.
    lower_ = logarithmic_ ? std::log(static_cast<double>(limits.lower)) : limits.lower;
    const double upper = logarithmic_ ? std::log(static_cast<double>(limits.upper)) : limits.upper;
    factor_ = 1.0 / (upper - lower_);
  }

  float at(float cost) const
  {
    if (limits_.lower == limits_.upper) {
      return cost > limits_.upper ? 1.0f : 0.0f;
    }
    double value = cost;
    if (logarithmic_) {
      value = cost > 0.0f ? std::log(value) : -std::numeric_limits<double>::infinity();
    }
    return static_cast<float>(std::min(std::max((value - lower_) * factor_, 0.0), 1.0));
  }

 private:
  CostLimits limits_;
  bool logarithmic_;
  double lower_;
  double factor_;
};

bool isOutside(const CostLimits& limits, float cost, bool* below)
{
  *below = cost < std::min(limits.lower, limits.upper);
  return *below || cost > std::max(limits.lower, limits.upper);
}

/// The color of a cost; -inf counts as one below all others.
Rgba8 colorOf(float cost, const CostColoring& coloring, const CostLimits& limits,
              const Positions& positions, const ColorTable& table)
{
  if (std::isnan(cost)) {
    return coloring.unknown;
  }
  if (cost > std::numeric_limits<float>::max() ||
      (coloring.mark_lethal && cost >= coloring.least_lethal)) {
    return coloring.lethal;
  }
  bool below = false;
  if (coloring.mark_outside && isOutside(limits, cost, &below)) {
    return below ? coloring.below : coloring.above;
  }
  return table.at(positions.at(cost));
}

/// @param value_of the value of a vertex or face
template <class ValueOf>
ColorSource sourceOf(ValueOf value_of, const CostColoring& coloring, const CostLimits& limits)
{
  const auto table = std::make_shared<const ColorTable>(coloring.scale, coloring.inverted);
  const Positions positions(coloring, limits);
  return [=](const std::uint32_t* sources, std::size_t count, Rgba8* colors) {
    for (std::size_t i = 0; i < count; ++i) {
      colors[i] = colorOf(value_of(sources[i]), coloring, limits, positions, *table);
    }
  };
}

CostLimits automaticLimits(const CostColoring& coloring, const CostSummary& summary)
{
  CostLimits limits = summary.limits;
  if (coloring.clipped > 0.0f) {
    const double clipped = std::min(static_cast<double>(coloring.clipped), 50.0);
    const CostLimits inner{summary.percentile(clipped), summary.percentile(100.0 - clipped)};
    if (inner.lower < inner.upper) {
      limits = inner;
    }
  }
  return limits;
}

/// Makes both limits positive, where one is and some cost is.
CostLimits positiveLimits(CostLimits limits, const CostSummary& summary)
{
  const float greater = std::max(limits.lower, limits.upper);
  if (summary.positive == 0 || greater <= 0.0f) {
    return limits;
  }
  const float least =
      summary.least_positive < greater ? summary.least_positive : LEAST_SHARE * greater;
  for (float* limit : {&limits.lower, &limits.upper}) {
    if (*limit <= 0.0f) {
      *limit = least;
    }
  }
  return limits;
}

}  // namespace

bool operator==(const CostColoring& a, const CostColoring& b)
{
  const auto settings = [](const CostColoring& c) {
    return std::tie(c.scale, c.inverted, c.logarithmic, c.custom_limits, c.limits.lower,
                    c.limits.upper, c.clipped, c.lethal, c.unknown, c.mark_lethal, c.least_lethal,
                    c.mark_outside, c.below, c.above);
  };
  return settings(a) == settings(b);
}

CostLimits limitsOf(const CostColoring& coloring, const CostSummary& summary)
{
  const CostLimits limits =
      coloring.custom_limits ? coloring.limits : automaticLimits(coloring, summary);
  return coloring.logarithmic ? positiveLimits(limits, summary) : limits;
}

bool isLogarithmic(const CostColoring& coloring, const CostLimits& limits)
{
  return coloring.logarithmic && limits.lower > 0.0f && limits.upper > 0.0f;
}

std::string coloringNote(const CostColoring& coloring, const CostSummary& summary)
{
  if (!coloring.logarithmic || summary.finite == 0) {
    return std::string();
  }
  const CostLimits limits = limitsOf(coloring, summary);
  if (!isLogarithmic(coloring, limits)) {
    return summary.positive == 0 ? "the scale is linear, since no cost is above 0"
                                 : "the scale is linear, since no limit is above 0";
  }
  std::ostringstream note;
  if (const std::size_t others = summary.finite - summary.positive) {
    note << others
         << (others == 1 ? " cost that is not above 0 has" : " costs that are not above 0 have")
         << " no logarithm: drawn as the lowest";
  }
  if (coloring.custom_limits && std::min(coloring.limits.lower, coloring.limits.upper) <= 0.0f) {
    note << (note.tellp() > 0 ? "; " : "") << "the scale begins at "
         << std::min(limits.lower, limits.upper) << ", since a limit is not above 0";
  }
  return note.str();
}

ColorSource colorSource(const CostLayerConstPtr& layer, const CostColoring& coloring)
{
  return sourceOf([layer](std::uint32_t i) { return layer->costs[i]; }, coloring,
                  limitsOf(coloring, layer->summary));
}

ColorSource heightSource(const MeshDataConstPtr& mesh, const CostColoring& coloring)
{
  return sourceOf([mesh](std::uint32_t i) { return mesh->vertices[i].position[2]; }, coloring,
                  limitsOf(coloring, CostSummary()));
}

}  // namespace rviz_mesh_plugin
