#include "incoming/mesh_store.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "base/erase_if.h"

namespace rviz_mesh_plugin {
namespace {

const char* const ON_FACES = " (faces)";

/// Null where there is none.
template <class Costs>
auto find(Costs& costs, const std::string& type, bool on_faces)
{
  const auto found = std::find_if(costs.begin(), costs.end(), [&](const CostLayerConstPtr& layer) {
    return layer->type == type && layer->on_faces == on_faces;
  });
  return found == costs.end() ? nullptr : &*found;
}

/// The name that tells a layer from the others of its geometry.
std::string nameOf(const CostLayer& layer, const MeshAttributes& attributes)
{
  const bool ambiguous = layer.on_faces && find(attributes.costs, layer.type, false);
  return ambiguous ? layer.type + ON_FACES : layer.type;
}

template <class Item>
void leaveOut(std::set<Item>& left_out, Item item)
{
  if (left_out.size() < MeshStore::MAX_LEFT_OUT) {
    left_out.insert(std::move(item));
  }
}

}  // namespace

bool MeshAttributes::leftOut(const std::string& name) const
{
  return !cost(name) &&
         std::any_of(costs_left_out.begin(), costs_left_out.end(), [&](const auto& layer) {
           return name == layer.first || (layer.second && name == layer.first + ON_FACES);
         });
}

CostLayerConstPtr MeshAttributes::cost(const std::string& name) const
{
  for (const CostLayerConstPtr& layer : costs) {
    if (nameOf(*layer, *this) == name) {
      return layer;
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
  eraseIf(meshes_, [&](const MeshDataConstPtr& other) { return other->uuid == mesh->uuid; });
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
  eraseIf(attributes_, [&](const MeshAttributes& other) {
    return !shown(other.uuid) && ++waiting > MAX_WAITING;
  });
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
  MeshAttributes& attributes = attributesOf(layer->uuid);
  auto& costs = attributes.costs;
  if (CostLayerConstPtr* found = find(costs, layer->type, layer->on_faces)) {
    *found = layer;
    return;
  }
  costs.push_back(layer);
  attributes.costs_left_out.erase({layer->type, layer->on_faces});
  std::size_t sum = std::accumulate(
      costs.begin(), costs.end(), std::size_t{0},
      [](std::size_t bytes, const CostLayerConstPtr& other) { return bytes + other->bytes(); });
  auto first = costs.begin();
  for (; sum > most_ && std::next(first) != costs.end(); ++first) {
    sum -= (*first)->bytes();
    leaveOut(attributes.costs_left_out, {(*first)->type, (*first)->on_faces});
  }
  costs.erase(costs.begin(), first);
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
  MeshAttributes& attributes = attributesOf(texture->uuid);
  auto& textures = attributes.textures;
  textures[texture->index] = texture;
  attributes.textures_left_out.erase(texture->index);
  std::size_t sum = std::accumulate(
      textures.begin(), textures.end(), std::size_t{0},
      [](std::size_t bytes, const auto& other) { return bytes + other.second->bytes(); });
  while (sum > most_ && textures.size() > 1) {
    sum -= std::prev(textures.end())->second->bytes();
    leaveOut(attributes.textures_left_out, textures.rbegin()->first);
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

void MeshStore::setLayerInfos(const std::string& uuid, LayerInfos infos)
{
  infos_uuid_ = uuid;
  infos_ = std::move(infos);
}

const LayerInfo& MeshStore::layerInfo(const std::string& uuid, const std::string& layer) const
{
  static const LayerInfo NOTHING;
  const auto found = uuid == infos_uuid_ ? infos_.find(layer) : infos_.end();
  return found == infos_.end() ? NOTHING : found->second;
}

bool MeshStore::changeCosts(const CostLayerConstPtr& layer)
{
  const auto& known = attributes(layer->uuid).costs;
  const auto* const before = find(known, layer->type, false);
  if (!before || (*before)->costs.size() != layer->costs.size()) {
    return false;  // and nothing that waits for its mesh has to go for it
  }
  *find(attributesOf(layer->uuid).costs, layer->type, false) = layer;
  return true;
}

void MeshStore::forget(MeshMember part)
{
  if (part == MeshMember::GEOMETRY) {
    meshes_.clear();
  }
  for (MeshAttributes& attributes : attributes_) {
    if (part == MeshMember::COSTS || part == MeshMember::FACE_COSTS) {
      eraseIf(attributes.costs, [&](const CostLayerConstPtr& layer) {
        return layer->on_faces == (part == MeshMember::FACE_COSTS);
      });
      eraseIf(attributes.costs_left_out,
              [&](const auto& layer) { return layer.second == (part == MeshMember::FACE_COSTS); });
    } else if (part == MeshMember::COLORS) {
      attributes.colors.reset();
    } else if (part == MeshMember::MATERIALS || part == MeshMember::TEXTURES) {
      attributes.materials.reset();
      attributes.textures.clear();
      attributes.textures_left_out.clear();
    } else if (part == MeshMember::LABELS) {
      attributes.labels.clear();
    }
  }
}

void MeshStore::clear()
{
  meshes_.clear();
  attributes_.clear();
  infos_.clear();
}

std::vector<std::string> MeshStore::costTypes() const
{
  std::vector<std::string> names;
  for (const MeshDataConstPtr& mesh : meshes_) {
    const MeshAttributes& of_mesh = attributes(mesh->uuid);
    for (const CostLayerConstPtr& layer : of_mesh.costs) {
      std::string name = nameOf(*layer, of_mesh);
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        names.push_back(std::move(name));
      }
    }
  }
  return names;
}

/// @param count how many of them a geometry has
template <class Count>
MeshStore::Waiting MeshStore::waiting(const Count& count) const
{
  Waiting sum;
  for (const MeshAttributes& attributes : attributes_) {
    const std::size_t found = shown(attributes.uuid) ? 0 : count(attributes);
    if (found > 0 && sum.count == 0) {
      sum.uuid = attributes.uuid;
    }
    sum.count += found;
  }
  return sum;
}

MeshStore::Waiting MeshStore::waitingCosts() const
{
  return waiting([](const MeshAttributes& attributes) { return attributes.costs.size(); });
}

MeshStore::Waiting MeshStore::waitingColors() const
{
  return waiting(
      [](const MeshAttributes& attributes) { return std::size_t(attributes.colors ? 1 : 0); });
}

MeshStore::Waiting MeshStore::waitingLabels() const
{
  return waiting([](const MeshAttributes& attributes) { return attributes.labels.size(); });
}

}  // namespace rviz_mesh_plugin
