#include "rviz_mesh_plugin/pending_costs.h"

#include <algorithm>

#include "rviz_mesh_plugin/mesh_painters.h"
#include "rviz_mesh_plugin/mesh_store.h"

namespace rviz_mesh_plugin {

void PendingCosts::take(const std::vector<CostUpdateConstPtr>& updates, MeshStore& store)
{
  for (const CostUpdateConstPtr& update : updates) {
    const CostLayerConstPtr layer = store.update(update);
    if (!layer) {
      continue;
    }
    Changed& changed = changed_[{update->uuid, update->type}];
    if (changed.layer != layer) {  // a new one is colored as a whole
      changed = {layer, {}};
    }
    auto& vertices = changed.vertices;
    vertices.insert(vertices.end(), update->vertices.begin(), update->vertices.end());
    if (vertices.size() > layer->costs.size()) {
      std::sort(vertices.begin(), vertices.end());
      vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    }
  }
}

bool PendingCosts::show(Clock::time_point now, float rate, MeshPainters& painters)
{
  const std::chrono::duration<float> interval(1.0f / rate);
  if (changed_.empty() || now - shown_ < interval) {
    return false;
  }
  shown_ = now;
  for (const auto& changed : changed_) {
    painters.updateCosts(changed.second.layer, changed.second.vertices);
  }
  changed_.clear();
  return true;
}

}  // namespace rviz_mesh_plugin
