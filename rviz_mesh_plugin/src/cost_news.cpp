#include "rviz_mesh_plugin/cost_news.h"

#include <algorithm>
#include <string>
#include <unordered_map>
#include <utility>

#include "rviz_mesh_plugin/cost_update.h"

namespace rviz_mesh_plugin {
namespace {

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
void eraseWhere(Items& items, const IsGone& is_gone)
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
  eraseWhere(updates, [&](const auto& update) { return isOf(*update, *joined); });
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
  eraseWhere(updates, [](const auto& update) { return !update; });
}

}  // namespace

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
