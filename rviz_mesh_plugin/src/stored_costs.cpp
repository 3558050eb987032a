#include "rviz_mesh_plugin/stored_costs.h"

#include <algorithm>
#include <utility>

#include "rviz_mesh_plugin/cost_update.h"

namespace rviz_mesh_plugin {

StoredCosts::StoredCosts(CostLayerConstPtr layer) : layer_(std::move(layer)) {}

std::uint64_t StoredCosts::stampOf(std::uint32_t vertex) const
{
  return vertex < stamps_.size() ? stamps_[vertex] : 0;
}

/// What updates have brought that are newer than another layer, as far as it fits that.
CostUpdateConstPtr StoredCosts::newerThan(const CostLayer& layer) const
{
  if (layer.outdated == 0 || newest_stamp_ <= layer.outdated) {
    return nullptr;  // nearly always; else all vertices are looked at
  }
  auto update = std::make_shared<CostUpdate>();
  update->uuid = layer_->uuid;
  update->type = layer_->type;
  const std::size_t size = std::min(layer.costs.size(), stamps_.size());
  for (std::uint32_t vertex = 0; vertex < size; ++vertex) {
    if (stamps_[vertex] > layer.outdated) {
      update->vertices.push_back(vertex);
      update->costs.push_back(layer_->costs[vertex]);
      update->stamps.push_back(stamps_[vertex]);
    }
  }
  return update->vertices.empty() ? nullptr : update;
}

void StoredCosts::replace(const CostLayerConstPtr& layer)
{
  const CostUpdateConstPtr newer = newerThan(*layer);
  layer_ = layer;
  own_.reset();
  stamps_.clear();
  newest_stamp_ = 0;
  std::string problem;
  if (newer) {
    apply(newer, problem);
  }
}

StoredCosts::Outcome StoredCosts::apply(const CostUpdateConstPtr& update, std::string& problem)
{
  problem.clear();
  const auto fresh = select(update, [&](std::uint32_t vertex, std::uint64_t stamp) {
    return !isOlder(stamp, layer_->stamp) && !isOlder(stamp, stampOf(vertex));
  });
  if (!fresh) {
    return Outcome::STALE;
  }
  if (!own_) {
    own_ = std::make_shared<CostLayer>(*layer_);
  }
  problem = applyUpdate(*own_, *fresh);
  if (!problem.empty()) {
    return Outcome::MISFIT;
  }
  layer_ = own_;
  if (fresh->stamp != 0 || !fresh->stamps.empty() || !stamps_.empty()) {
    stamps_.resize(layer_->costs.size());
    for (std::size_t i = 0; i < fresh->vertices.size(); ++i) {
      stamps_[fresh->vertices[i]] = fresh->stampOf(i);
      newest_stamp_ = std::max(newest_stamp_, fresh->stampOf(i));
    }
  }
  return Outcome::CHANGED;
}

}  // namespace rviz_mesh_plugin
