#include "incoming/cost_update.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "base/cost_summary.h"
#include "conversion/validation.h"

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

using Updates = std::vector<CostUpdateConstPtr>;

/// More than this is not kept while nobody takes it; the oldest goes.
constexpr std::size_t MAX_LAYERS = 256;
/// More updates of a layer than this are joined, so that few are left to the GUI thread.
constexpr std::size_t MAX_UPDATES = 16;

bool isSame(const CostLayer& a, const CostLayer& b)
{
  return a.uuid == b.uuid && a.type == b.type && a.on_faces == b.on_faces;
}

template <class Layer>
bool isOf(const CostUpdate& update, const Layer& layer)
{
  return update.uuid == layer.uuid && update.type == layer.type;
}

template <class Items, class IsGone>
void eraseUpdates(Items& items, const IsGone& is_gone)
{
  items.erase(std::remove_if(items.begin(), items.end(), is_gone), items.end());
}

/// All updates of one layer as one, in place of the newest: each vertex once.
void join(Updates& updates, const CostUpdate& newest)
{
  std::unordered_map<std::uint32_t, std::pair<std::uint64_t, float>> costs;
  for (const CostUpdateConstPtr& update : updates) {
    for (std::size_t i = 0; isOf(*update, newest) && i < update->vertices.size(); ++i) {
      const std::pair<std::uint64_t, float> cost(update->stampOf(i), update->costs[i]);
      const auto place = costs.emplace(update->vertices[i], cost);
      if (!place.second && !isOlder(cost.first, place.first->second.first)) {
        place.first->second = cost;
      }
    }
  }
  auto joined = std::make_shared<CostUpdate>();
  joined->uuid = newest.uuid;
  joined->type = newest.type;
  joined->vertices.reserve(costs.size());
  joined->costs.reserve(costs.size());
  joined->stamps.reserve(costs.size());
  for (const auto& cost : costs) {
    joined->vertices.push_back(cost.first);
    joined->stamps.push_back(cost.second.first);
    joined->costs.push_back(cost.second.second);
  }
  eraseUpdates(updates, [&](const auto& update) { return isOf(*update, *joined); });
  updates.push_back(joined);
}

void append(Updates& updates, const CostUpdateConstPtr& update)
{
  updates.push_back(update);
  const auto count = std::count_if(updates.begin(), updates.end(),
                                   [&](const auto& other) { return isOf(*other, *update); });
  if (static_cast<std::size_t>(count) > MAX_UPDATES) {
    join(updates, *update);
  }
  if (updates.size() > MAX_LAYERS * MAX_UPDATES) {
    updates.erase(updates.begin());
  }
}

/// Leaves what is newer than the layer.
void outdate(Updates& updates, const CostLayer& layer)
{
  for (CostUpdateConstPtr& update : updates) {
    if (isOf(*update, layer)) {
      update = leftOver(update, layer);
    }
  }
  eraseUpdates(updates, [](const auto& update) { return !update; });
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

void CostNews::add(const std::shared_ptr<CostLayer>& layer)
{
  if (!layer->on_faces) {
    outdate(updates, *layer);  // the store does so with the earlier ones
  }
  const auto before = std::find_if(costs.begin(), costs.end(),
                                   [&](const auto& other) { return isSame(*other, *layer); });
  if (before != costs.end()) {
    const bool all = layer->outdated == 0 || (*before)->outdated == 0;
    layer->outdated = all ? 0 : std::max(layer->outdated, (*before)->outdated);
    costs.erase(before);
  } else if (!layer->on_faces) {
    const auto moved = std::stable_partition(
        updates.begin(), updates.end(), [&](const auto& update) { return !isOf(*update, *layer); });
    const Updates earlier(moved, updates.end());
    updates.erase(moved, updates.end());
    for (const CostUpdateConstPtr& update : earlier) {
      append(earlier_updates, update);
    }
  }
  costs.push_back(layer);
  if (costs.size() > MAX_LAYERS) {
    costs.erase(costs.begin());
  }
}

void CostNews::add(const CostUpdateConstPtr& update)
{
  const auto layer = std::find_if(costs.begin(), costs.end(), [&](const auto& other) {
    return !other->on_faces && isOf(*update, *other);
  });
  if (layer != costs.end() && isOlder(update->stamp, (*layer)->stamp)) {
    ++stale;
    return;
  }
  append(updates, update);
}

}  // namespace rviz_mesh_plugin
