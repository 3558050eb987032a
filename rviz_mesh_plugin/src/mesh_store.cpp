#include "rviz_mesh_plugin/mesh_store.h"

#include <algorithm>

namespace rviz_mesh_plugin {

MeshStore::Attributes& MeshStore::attributesOf(const std::string& uuid)
{
  const auto found =
      std::find_if(attributes_.begin(), attributes_.end(),
                   [&](const Attributes& attributes) { return attributes.uuid == uuid; });
  if (found != attributes_.end()) {
    attributes_.splice(attributes_.begin(), attributes_, found);
    return attributes_.front();
  }
  attributes_.emplace_front();
  attributes_.front().uuid = uuid;
  if (attributes_.size() > MAX_MESHES) {
    auto last = std::prev(attributes_.end());
    if (geometry_ && last->uuid == geometry_->uuid) {
      --last;
    }
    attributes_.erase(last);
  }
  return attributes_.front();
}

const MeshStore::Attributes* MeshStore::shown() const
{
  if (geometry_) {
    for (const Attributes& attributes : attributes_) {
      if (attributes.uuid == geometry_->uuid) {
        return &attributes;
      }
    }
  }
  return nullptr;
}

void MeshStore::addCosts(const CostLayerConstPtr& layer)
{
  auto& costs = attributesOf(layer->uuid).costs;
  for (auto& other : costs) {
    if (other->type == layer->type) {
      other = layer;
      return;
    }
  }
  if (costs.size() == MAX_LAYERS) {
    costs.erase(costs.begin());
  }
  costs.push_back(layer);
}

void MeshStore::addColors(const ColorLayerConstPtr& layer)
{
  attributesOf(layer->uuid).colors = layer;
}

void MeshStore::clearCosts()
{
  for (Attributes& attributes : attributes_) {
    attributes.costs.clear();
  }
}

void MeshStore::clearColors()
{
  for (Attributes& attributes : attributes_) {
    attributes.colors.reset();
  }
}

void MeshStore::clear()
{
  geometry_.reset();
  attributes_.clear();
}

std::vector<std::string> MeshStore::costTypes() const
{
  std::vector<std::string> types;
  if (const Attributes* attributes = shown()) {
    for (const auto& layer : attributes->costs) {
      types.push_back(layer->type);
    }
  }
  return types;
}

CostLayerConstPtr MeshStore::costs(const std::string& type) const
{
  if (const Attributes* attributes = shown()) {
    for (const auto& layer : attributes->costs) {
      if (layer->type == type) {
        return layer;
      }
    }
  }
  return nullptr;
}

ColorLayerConstPtr MeshStore::colors() const
{
  const Attributes* attributes = shown();
  return attributes ? attributes->colors : nullptr;
}

std::size_t MeshStore::waitingCosts() const
{
  std::size_t count = 0;
  for (const Attributes& attributes : attributes_) {
    count += &attributes == shown() ? 0 : attributes.costs.size();
  }
  return count;
}

std::size_t MeshStore::waitingColors() const
{
  return static_cast<std::size_t>(std::count_if(
      attributes_.begin(), attributes_.end(),
      [&](const Attributes& attributes) { return &attributes != shown() && attributes.colors; }));
}

}  // namespace rviz_mesh_plugin
