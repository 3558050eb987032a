#include "incoming/cost_order.h"

#include <algorithm>
#include <cmath>
#include <memory>
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

/// Layers that are known are as many as are stored; of those that are forgotten, updates wait until
/// they come again.
constexpr std::size_t MAX_KNOWN_LAYERS = 4096;

/// Whether something is older than something else; what has no stamp (0) is neither older nor
/// newer.
constexpr bool isOlder(std::uint64_t stamp, std::uint64_t than)
{
  return stamp != 0 && than != 0 && stamp < than;
}

/// Why an update cannot be applied to a layer of this size; else empty.
std::string misfitOf(const CostUpdate& update, std::size_t size)
{
  if (update.vertices.size() != update.costs.size()) {
    return "an update of layer '" + update.type + "' has " + std::to_string(update.costs.size()) +
           " costs for " + std::to_string(update.vertices.size()) + " vertices";
  }
  const auto misfit = checkUpdateFits(update, size);
  return misfit ? "an update of layer '" + update.type + "': " + misfit->sentence() : "";
}

}  // namespace

std::string applyUpdate(CostLayer& layer, const CostUpdate& update)
{
  std::string misfit = misfitOf(update, layer.costs.size());
  if (!misfit.empty()) {
    return misfit;
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

void CostOrder::Layer::remember(const CostUpdate& update)
{
  if (update.stamp == 0 && stamps.empty()) {
    return;
  }
  stamps.resize(size);
  costs.resize(size);
  for (std::size_t i = 0; i < update.vertices.size(); ++i) {
    stamps[update.vertices[i]] = update.stamp;
    costs[update.vertices[i]] = update.costs[i];
  }
  newest_stamp = std::max(newest_stamp, update.stamp);
}

void CostOrder::remember(Layer& layer, const CostUpdate& update)
{
  layer.remember(update);
  std::size_t values = layer.stamps.size();
  for (Layer& other : layers_) {  // the last changed first
    values += &other == &layer ? 0 : other.stamps.size();
    if (&other != &layer && values > max_remembered_) {
      values -= other.stamps.size();
      std::vector<std::uint64_t>().swap(other.stamps);
      std::vector<float>().swap(other.costs);
    }
  }
}

template <class Costs>
CostOrder::Layer* CostOrder::find(const Costs& costs)
{
  const auto found = std::find_if(layers_.begin(), layers_.end(), [&](const Layer& layer) {
    return layer.uuid == costs.uuid && layer.type == costs.type;
  });
  if (found == layers_.end()) {
    return nullptr;
  }
  layers_.splice(layers_.begin(), layers_, found);
  return &layers_.front();
}

std::string CostOrder::arrange(CostLayer& layer)
{
  Layer before;
  Layer* known = find(layer);
  if (known) {
    std::swap(before, *known);
  } else {
    layers_.emplace_front();
    known = &layers_.front();
    if (layers_.size() > MAX_KNOWN_LAYERS) {
      layers_.pop_back();
    }
  }
  known->uuid = layer.uuid;
  known->type = layer.type;
  known->stamp = layer.stamp;
  known->size = layer.costs.size();
  const auto is_newer = [&](std::uint64_t stamp) {
    return layer.stamp != 0 && stamp > layer.stamp;
  };
  if (is_newer(before.newest_stamp)) {  // hardly ever; else all vertices are looked at
    CostUpdate newer;
    known->stamps.resize(known->size);
    known->costs.resize(known->size);
    known->newest_stamp = before.newest_stamp;
    const std::size_t size = std::min(known->size, before.stamps.size());
    for (std::uint32_t vertex = 0; vertex < size; ++vertex) {
      if (is_newer(before.stamps[vertex])) {
        newer.vertices.push_back(vertex);
        newer.costs.push_back(before.costs[vertex]);
        known->stamps[vertex] = before.stamps[vertex];
        known->costs[vertex] = before.costs[vertex];
      }
    }
    applyUpdate(layer, newer);
  }
  std::string problem;
  for (auto item = waiting_.begin(); item != waiting_.end();) {
    const CostUpdateConstPtr update = *item;
    if (update->uuid != layer.uuid || update->type != layer.type) {
      ++item;
      continue;
    }
    waiting_values_ -= update->costs.size();
    item = waiting_.erase(item);
    if (is_newer(update->stamp)) {
      if (const auto part = counting(*known, update, problem)) {
        applyUpdate(layer, *part);
      }
    }
  }
  return problem;
}

CostUpdateConstPtr CostOrder::arrange(const CostUpdateConstPtr& update, std::string& problem)
{
  problem.clear();
  if (update->vertices.empty() && update->costs.empty()) {
    return nullptr;  // else a whole layer would be copied and shown for nothing
  }
  if (Layer* layer = find(*update)) {
    return counting(*layer, update, problem);
  }
  keepWaiting(update);
  return nullptr;
}

/// The part of an update of a layer that counts, which is remembered; null where none does.
CostUpdateConstPtr CostOrder::counting(Layer& layer, const CostUpdateConstPtr& update,
                                       std::string& problem)
{
  const auto counts = [&](std::uint32_t vertex) {
    return layer.stamps.empty() || !isOlder(update->stamp, layer.stamps[vertex]);
  };
  if (isOlder(update->stamp, layer.stamp)) {
    ++stale_;
    return nullptr;
  }
  problem = misfitOf(*update, layer.size);
  if (!problem.empty()) {
    return nullptr;
  }
  if (std::all_of(update->vertices.begin(), update->vertices.end(), counts)) {
    remember(layer, *update);
    return update;
  }
  auto part = std::make_shared<CostUpdate>();
  part->uuid = update->uuid;
  part->type = update->type;
  part->stamp = update->stamp;
  for (std::size_t i = 0; i < update->vertices.size(); ++i) {
    if (counts(update->vertices[i])) {
      part->vertices.push_back(update->vertices[i]);
      part->costs.push_back(update->costs[i]);
    }
  }
  if (part->vertices.empty()) {
    ++stale_;
    return nullptr;
  }
  remember(layer, *part);
  return part;
}

void CostOrder::keepWaiting(const CostUpdateConstPtr& update)
{
  if (update->stamp == 0) {
    return;  // any layer that comes later is newer
  }
  waiting_.push_back(update);
  waiting_values_ += update->costs.size();
  while (waiting_.size() > MAX_WAITING_UPDATES ||
         (waiting_values_ > MAX_WAITING_VALUES && waiting_.size() > 1)) {
    waiting_values_ -= waiting_.front()->costs.size();
    waiting_.pop_front();
  }
}

void CostOrder::forgetUpdates()
{
  waiting_.clear();
  waiting_values_ = 0;
  stale_ = 0;
}

}  // namespace rviz_mesh_plugin
