#include "incoming/mesh_store.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "incoming/cost_update.h"

namespace rviz_mesh_plugin {
namespace {

const char* const ON_FACES = " (faces)";

const StoredCosts* find(const std::vector<StoredCosts>& costs, const std::string& type,
                        bool on_faces)
{
  for (const StoredCosts& stored : costs) {
    if (stored.layer()->type == type && stored.layer()->on_faces == on_faces) {
      return &stored;
    }
  }
  return nullptr;
}

/// The name that tells a layer from the others of its geometry.
std::string nameOf(const CostLayer& layer, const MeshAttributes& attributes)
{
  const bool ambiguous = layer.on_faces && find(attributes.costs, layer.type, false);
  return ambiguous ? layer.type + ON_FACES : layer.type;
}

}  // namespace

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

CostLayerConstPtr MeshAttributes::cost(const std::string& name) const
{
  for (const StoredCosts& stored : costs) {
    if (nameOf(*stored.layer(), *this) == name) {
      return stored.layer();
    }
  }
  return nullptr;
}

void MeshStore::setCapacity(std::size_t capacity)
{
  capacity_ = std::max<std::size_t>(1, capacity);
  if (meshes_.size() > capacity_) {
    meshes_.resize(capacity_);
  }
}

void MeshStore::addMesh(const MeshDataConstPtr& mesh)
{
  meshes_.erase(
      std::remove_if(meshes_.begin(), meshes_.end(),
                     [&](const MeshDataConstPtr& other) { return other->uuid == mesh->uuid; }),
      meshes_.end());
  meshes_.insert(meshes_.begin(), mesh);
  setCapacity(capacity_);
  // Labels of "the only mesh" that came before it.
  if (auto early = attributes(std::string()).labels; !early.empty() && !mesh->uuid.empty()) {
    attributesOf(std::string()).labels.clear();
    attributesOf(mesh->uuid).labels.merge(early);
  }
}

MeshDataConstPtr MeshStore::mesh(const std::string& uuid) const
{
  const auto found = std::find_if(meshes_.begin(), meshes_.end(),
                                  [&](const MeshDataConstPtr& mesh) { return mesh->uuid == uuid; });
  return found == meshes_.end() ? nullptr : *found;
}

MeshAttributes& MeshStore::attributesOf(const std::string& uuid)
{
  const auto found = std::find_if(attributes_.begin(), attributes_.end(),
                                  [&](const MeshAttributes& other) { return other.uuid == uuid; });
  if (found != attributes_.end()) {
    attributes_.splice(attributes_.begin(), attributes_, found);
    return attributes_.front();
  }
  attributes_.emplace_front();
  attributes_.front().uuid = uuid;
  std::size_t waiting = 0;
  for (auto item = attributes_.begin(); item != attributes_.end();) {
    const bool surplus = !shown(item->uuid) && ++waiting > MAX_WAITING;
    item = surplus ? attributes_.erase(item) : std::next(item);
  }
  return attributes_.front();
}

const MeshAttributes& MeshStore::attributes(const std::string& uuid) const
{
  static const MeshAttributes NOTHING;
  const auto found = std::find_if(attributes_.begin(), attributes_.end(),
                                  [&](const MeshAttributes& other) { return other.uuid == uuid; });
  return found == attributes_.end() ? NOTHING : *found;
}

const MeshAttributes& MeshStore::attributes() const
{
  return attributes(meshes_.empty() ? std::string() : meshes_.front()->uuid);
}

void MeshStore::addCosts(const CostLayerConstPtr& layer)
{
  auto& costs = attributesOf(layer->uuid).costs;
  if (const StoredCosts* found = find(costs, layer->type, layer->on_faces)) {
    costs[static_cast<std::size_t>(found - costs.data())].replace(layer);
    return;
  }
  if (costs.size() == MAX_LAYERS) {
    costs.erase(costs.begin());
  }
  costs.emplace_back(layer);
  applyWaiting(costs.back());
}

void MeshStore::addColors(const ColorLayerConstPtr& layer)
{
  attributesOf(layer->uuid).colors = layer;
}

void MeshStore::addMaterials(const MaterialsConstPtr& materials)
{
  attributesOf(materials->uuid).materials = materials;
}

void MeshStore::addTexture(const TextureImageConstPtr& texture)
{
  auto& textures = attributesOf(texture->uuid).textures;
  textures[texture->index] = texture;
  if (textures.size() > MAX_TEXTURES) {
    textures.erase(std::prev(textures.end()));
  }
}

void MeshStore::addLabels(const LabelSetConstPtr& labels)
{
  const MeshDataConstPtr only = newest();
  auto& stored = attributesOf(labels->uuid.empty() && only ? only->uuid : labels->uuid).labels;
  if (labels->all) {
    stored.clear();
  }
  for (const LabelCluster& cluster : labels->clusters) {
    if (cluster.faces.empty()) {
      stored.erase(cluster.label);
    } else {
      stored[cluster.label] = LabelClusterConstPtr(labels, &cluster);
    }
  }
}

CostLayerConstPtr MeshStore::update(const CostUpdateConstPtr& update)
{
  update_problem_.clear();
  if (!find(attributes(update->uuid).costs, update->type, false)) {
    keepWaiting(update);  // and nothing that waits for its mesh has to go for it
    return nullptr;
  }
  auto& costs = attributesOf(update->uuid).costs;
  const StoredCosts* found = find(costs, update->type, false);
  return apply(costs[static_cast<std::size_t>(found - costs.data())], update);
}

CostLayerConstPtr MeshStore::apply(StoredCosts& costs, const CostUpdateConstPtr& update)
{
  const StoredCosts::Outcome outcome = costs.apply(update, update_problem_);
  stale_updates_ += outcome == StoredCosts::Outcome::STALE ? 1 : 0;
  return outcome == StoredCosts::Outcome::CHANGED ? costs.layer() : nullptr;
}

void MeshStore::keepWaiting(const CostUpdateConstPtr& update)
{
  waiting_updates_.push_back(update);
  waiting_values_ += update->costs.size();
  while (waiting_updates_.size() > MAX_WAITING_UPDATES ||
         (waiting_values_ > MAX_WAITING_VALUES && waiting_updates_.size() > 1)) {
    waiting_values_ -= waiting_updates_.front()->costs.size();
    waiting_updates_.pop_front();
  }
}

void MeshStore::applyWaiting(StoredCosts& costs)
{
  if (costs.layer()->on_faces) {
    return;
  }
  const CostLayerConstPtr arrived = costs.layer();
  for (auto item = waiting_updates_.begin(); item != waiting_updates_.end();) {
    const CostUpdateConstPtr update = *item;
    if (update->uuid != arrived->uuid || update->type != arrived->type) {
      ++item;
      continue;
    }
    waiting_values_ -= update->costs.size();
    item = waiting_updates_.erase(item);
    if (const auto newer = leftOver(update, *arrived)) {
      apply(costs, newer);
    }
  }
}

void MeshStore::clearCosts(bool on_faces)
{
  for (MeshAttributes& attributes : attributes_) {
    auto& costs = attributes.costs;
    costs.erase(std::remove_if(costs.begin(), costs.end(),
                               [&](const StoredCosts& stored) {
                                 return stored.layer()->on_faces == on_faces;
                               }),
                costs.end());
  }
}

void MeshStore::clearUpdates()
{
  waiting_updates_.clear();
  waiting_values_ = 0;
  update_problem_.clear();
  stale_updates_ = 0;
}

void MeshStore::clearColors()
{
  for (MeshAttributes& attributes : attributes_) {
    attributes.colors.reset();
  }
}

void MeshStore::clearMaterials()
{
  for (MeshAttributes& attributes : attributes_) {
    attributes.materials.reset();
    attributes.textures.clear();
  }
}

void MeshStore::clearLabels()
{
  for (MeshAttributes& attributes : attributes_) {
    attributes.labels.clear();
  }
}

void MeshStore::clear()
{
  clearUpdates();
  meshes_.clear();
  attributes_.clear();
}

std::vector<std::string> MeshStore::costTypes() const
{
  std::vector<std::string> names;
  for (const MeshDataConstPtr& mesh : meshes_) {
    const MeshAttributes& of_mesh = attributes(mesh->uuid);
    for (const StoredCosts& stored : of_mesh.costs) {
      std::string name = nameOf(*stored.layer(), of_mesh);
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        names.push_back(std::move(name));
      }
    }
  }
  return names;
}

std::size_t MeshStore::waitingCosts() const
{
  std::size_t count = 0;
  for (const MeshAttributes& attributes : attributes_) {
    count += shown(attributes.uuid) ? 0 : attributes.costs.size();
  }
  return count;
}

std::size_t MeshStore::waitingColors() const
{
  return static_cast<std::size_t>(
      std::count_if(attributes_.begin(), attributes_.end(), [&](const MeshAttributes& attributes) {
        return attributes.colors && !shown(attributes.uuid);
      }));
}

}  // namespace rviz_mesh_plugin
