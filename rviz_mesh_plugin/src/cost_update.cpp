#include "rviz_mesh_plugin/cost_update.h"

#include <algorithm>
#include <cmath>

#include "rviz_mesh_plugin/cost_summary.h"
#include "rviz_mesh_plugin/validation.h"

namespace rviz_mesh_plugin {
namespace {

/// Adds a cost to the counts, or takes it away.
void count(CostSummary& summary, float cost, std::size_t by)
{
  std::size_t& kind =
      std::isnan(cost) ? summary.unknown : (std::isinf(cost) ? summary.lethal : summary.finite);
  kind += by;
  summary.positive += std::isfinite(cost) && cost > 0.0f ? by : 0;
}

void widen(CostSummary& summary, float cost)
{
  const bool first = summary.finite == 1;
  CostLimits& limits = summary.limits;
  limits.lower = first ? cost : std::min(limits.lower, cost);
  limits.upper = first ? cost : std::max(limits.upper, cost);
  if (cost > 0.0f && (summary.positive == 1 || cost < summary.least_positive)) {
    summary.least_positive = cost;
  }
}

}  // namespace

CostUpdateConstPtr select(const CostUpdateConstPtr& update,
                          const std::function<bool(std::uint32_t, std::uint64_t)>& counts)
{
  std::vector<std::size_t> chosen;
  const std::size_t size = update->vertices.size();
  if (update->costs.size() != size) {
    return update;  // applyUpdate() tells that
  }
  for (std::size_t i = 0; i < size; ++i) {
    if (counts(update->vertices[i], update->stampOf(i))) {
      chosen.push_back(i);
    }
  }
  if (chosen.size() == size) {
    return update;
  }
  if (chosen.empty()) {
    return nullptr;
  }
  auto part = std::make_shared<CostUpdate>();
  part->uuid = update->uuid;
  part->type = update->type;
  part->stamp = update->stamp;
  for (const std::size_t i : chosen) {
    part->vertices.push_back(update->vertices[i]);
    part->costs.push_back(update->costs[i]);
    if (!update->stamps.empty()) {
      part->stamps.push_back(update->stamps[i]);
    }
  }
  return part;
}

CostUpdateConstPtr leftOver(const CostUpdateConstPtr& update, const CostLayer& layer)
{
  if (layer.outdated == 0 || update->vertices.empty()) {
    return nullptr;
  }
  return select(update, [&](std::uint32_t, std::uint64_t stamp) { return stamp > layer.outdated; });
}

std::string applyUpdate(CostLayer& layer, const CostUpdate& update)
{
  if (update.vertices.size() != update.costs.size()) {
    return "an update of layer '" + layer.type + "' has " + std::to_string(update.costs.size()) +
           " costs for " + std::to_string(update.vertices.size()) + " vertices";
  }
  if (const auto misfit = checkUpdateFits(update, layer.costs.size())) {
    return "an update of layer '" + layer.type + "': " + misfit->sentence();
  }
  CostSummary& summary = layer.summary;
  for (std::size_t i = 0; i < update.vertices.size(); ++i) {
    float& cost = layer.costs[update.vertices[i]];
    count(summary, cost, std::size_t(-1));
    cost = update.costs[i];
    count(summary, cost, 1);
    if (std::isfinite(cost)) {
      widen(summary, cost);
    }
  }
  if (layer.costs.size() <= MAX_SUMMARIZED_AGAIN) {
    summary = summarizeCosts(layer.costs);
  }
  return std::string();
}

}  // namespace rviz_mesh_plugin
