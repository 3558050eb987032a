#include "rviz_mesh_plugin/mesh_inbox.h"

#include <algorithm>
#include <exception>
#include <unordered_map>
#include <utility>

#include "rviz_mesh_plugin/attribute_conversion.h"
#include "rviz_mesh_plugin/material_conversion.h"

namespace rviz_mesh_plugin {
namespace {

/// More than this is not kept while nobody takes it; the oldest goes.
constexpr std::size_t MAX_LAYERS = 256;
constexpr std::size_t MAX_MESHES = 8;
constexpr std::size_t MAX_TEXTURES = 4096;
/// More updates of a layer than this are joined, so that few are left to the GUI thread.
constexpr std::size_t MAX_UPDATES = 16;

/// Puts @a item behind the others, in place of the one that it supersedes.
template <class Pointer, class IsSame>
void replaceOrAppend(std::vector<Pointer>& items, const Pointer& item, std::size_t most,
                     const IsSame& is_same)
{
  items.erase(std::remove_if(items.begin(), items.end(), is_same), items.end());
  items.push_back(item);
  if (items.size() > most) {
    items.erase(items.begin());
  }
}

template <class Items, class IsGone>
void eraseWhere(Items& items, const IsGone& is_gone)
{
  items.erase(std::remove_if(items.begin(), items.end(), is_gone), items.end());
}

bool isOfLayer(const CostUpdate& update, const std::string& uuid, const std::string& type)
{
  return update.uuid == uuid && update.type == type;
}

/// All updates of one layer as one, in place of the newest: each vertex once, with its last cost.
void joinUpdates(std::vector<CostUpdateConstPtr>& updates, const CostUpdateConstPtr& newest)
{
  auto joined = std::make_shared<CostUpdate>();
  joined->uuid = newest->uuid;
  joined->type = newest->type;
  std::unordered_map<std::uint32_t, float> costs;
  for (const CostUpdateConstPtr& update : updates) {
    if (isOfLayer(*update, newest->uuid, newest->type)) {
      for (std::size_t i = 0; i < update->vertices.size(); ++i) {
        costs[update->vertices[i]] = update->costs[i];
      }
    }
  }
  joined->vertices.reserve(costs.size());
  joined->costs.reserve(costs.size());
  for (const auto& cost : costs) {
    joined->vertices.push_back(cost.first);
    joined->costs.push_back(cost.second);
  }
  eraseWhere(updates,
             [&](const auto& update) { return isOfLayer(*update, joined->uuid, joined->type); });
  updates.push_back(joined);
}

/// Joins neighbors of the same mesh: of each label the last cluster.
void joinLabels(std::vector<LabelSetConstPtr>& sets)
{
  std::vector<LabelSetConstPtr> joined;
  std::shared_ptr<LabelSet> last;
  std::unordered_map<std::string, std::size_t> places;
  for (const LabelSetConstPtr& set : sets) {
    if (!last || last->uuid != set->uuid) {
      last = std::make_shared<LabelSet>();
      last->uuid = set->uuid;
      last->all = set->all;
      joined.push_back(last);
      places.clear();
    }
    for (const LabelCluster& cluster : set->clusters) {
      const auto place = places.emplace(cluster.label, last->clusters.size());
      if (place.second) {
        last->clusters.push_back(cluster);
      } else {
        last->clusters[place.first->second] = cluster;
      }
    }
  }
  sets = std::move(joined);
}

}  // namespace

template <class Convert, class Store>
bool MeshInbox::accept(const Convert& convert, Reception InboxContent::*reception,
                       const Store& store, const Flag* dropped)
{
  std::string refusal;
  decltype(convert()) converted;
  try {
    converted = convert();
  } catch (const RejectedMessage& rejected) {
    refusal = rejected.what();
  } catch (const std::exception& error) {  // out of memory
    refusal = std::string("the message could not be converted: ") + error.what();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (dropped != nullptr && *dropped) {
    return false;
  }
  Reception& log = content_.*reception;
  if (converted) {
    try {
      store(converted);
    } catch (const std::exception& error) {
      refusal = std::string("the message could not be kept: ") + error.what();
      converted.reset();
    }
  }
  ++(converted ? log.accepted : log.refused);
  log.refusal = refusal;
  return converted != nullptr;
}

void MeshInbox::store(const CostLayerConstPtr& layer)
{
  replaceOrAppend(content_.costs, layer, MAX_LAYERS, [&](const CostLayerConstPtr& other) {
    return other->uuid == layer->uuid && other->type == layer->type &&
           other->on_faces == layer->on_faces;
  });
  if (!layer->on_faces) {
    eraseWhere(content_.updates,
               [&](const auto& update) { return isOfLayer(*update, layer->uuid, layer->type); });
  }
}

void MeshInbox::store(const CostUpdateConstPtr& update)
{
  auto& updates = content_.updates;
  updates.push_back(update);
  const auto count = std::count_if(updates.begin(), updates.end(), [&](const auto& other) {
    return isOfLayer(*other, update->uuid, update->type);
  });
  if (static_cast<std::size_t>(count) > MAX_UPDATES) {
    joinUpdates(updates, update);
  }
  if (updates.size() > MAX_LAYERS * MAX_UPDATES) {
    updates.erase(updates.begin());
  }
}

void MeshInbox::store(const LabelSetConstPtr& labels)
{
  auto& sets = content_.labels;
  if (labels->all) {
    eraseWhere(sets, [&](const auto& other) { return other->uuid == labels->uuid; });
  }
  sets.push_back(labels);
  if (sets.size() > MAX_LAYERS) {
    joinLabels(sets);
  }
  if (sets.size() > MAX_LAYERS) {
    sets.erase(sets.begin());
  }
}

bool MeshInbox::receive(const mesh_msgs::MeshVertexCostsStamped& message, const Flag* dropped)
{
  return accept([&]() { return convert(message); }, &InboxContent::costs_reception,
                [this](const auto& layer) { store(layer); }, dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshFaceCostsStamped& message)
{
  return accept([&]() { return convert(message); }, &InboxContent::face_costs_reception,
                [this](const auto& layer) { store(layer); });
}

bool MeshInbox::receive(const mesh_msgs::MeshVertexCostsSparseStamped& message)
{
  return accept([&]() { return convert(message); }, &InboxContent::updates_reception,
                [this](const auto& update) { store(update); });
}

bool MeshInbox::receive(const mesh_msgs::MeshVertexColorsStamped& message, const Flag* dropped)
{
  const auto store = [this](const ColorLayerConstPtr& layer) {
    replaceOrAppend(content_.colors, layer, MAX_MESHES,
                    [&](const ColorLayerConstPtr& other) { return other->uuid == layer->uuid; });
  };
  return accept([&]() { return convert(message); }, &InboxContent::colors_reception, store,
                dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshMaterialsStamped& message, const Flag* dropped)
{
  const auto store = [this](const MaterialsConstPtr& materials) {
    replaceOrAppend(content_.materials, materials, MAX_MESHES,
                    [&](const MaterialsConstPtr& other) { return other->uuid == materials->uuid; });
  };
  return accept([&]() { return convert(message); }, &InboxContent::materials_reception, store,
                dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshTexture& message, const Flag* dropped)
{
  const auto store = [this](const TextureImageConstPtr& image) {
    replaceOrAppend(content_.textures, image, MAX_TEXTURES, [&](const TextureImageConstPtr& other) {
      return other->uuid == image->uuid && other->index == image->index;
    });
  };
  return accept([&]() { return convert(message); }, &InboxContent::textures_reception, store,
                dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshFaceCluster& message)
{
  return accept([&]() { return convert(message); }, &InboxContent::labels_reception,
                [this](const LabelSetConstPtr& labels) { store(labels); });
}

bool MeshInbox::receiveLabels(const std::string& uuid,
                              const std::vector<mesh_msgs::MeshFaceCluster>& clusters, bool all,
                              const Flag* dropped)
{
  std::string left_out;
  const bool accepted = accept([&]() { return convertLabels(uuid, clusters, all, left_out); },
                               &InboxContent::labels_reception,
                               [this](const LabelSetConstPtr& labels) { store(labels); }, dropped);
  if (accepted && !left_out.empty()) {
    const std::lock_guard<std::mutex> lock(mutex_);
    content_.labels_reception.refusal = left_out;
  }
  return accepted;
}

InboxContent MeshInbox::take()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  InboxContent taken = std::move(content_);
  content_ = InboxContent();
  content_.costs_reception = taken.costs_reception;
  content_.face_costs_reception = taken.face_costs_reception;
  content_.updates_reception = taken.updates_reception;
  content_.colors_reception = taken.colors_reception;
  content_.materials_reception = taken.materials_reception;
  content_.textures_reception = taken.textures_reception;
  content_.labels_reception = taken.labels_reception;
  return taken;
}

void MeshInbox::clearCosts()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  eraseWhere(content_.costs, [](const auto& layer) { return !layer->on_faces; });
  content_.costs_reception = Reception();
}

void MeshInbox::clearFaceCosts()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  eraseWhere(content_.costs, [](const auto& layer) { return layer->on_faces; });
  content_.face_costs_reception = Reception();
}

void MeshInbox::clearUpdates()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  content_.updates.clear();
  content_.updates_reception = Reception();
}

void MeshInbox::clearColors()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  content_.colors.clear();
  content_.colors_reception = Reception();
}

void MeshInbox::clearMaterials()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  content_.materials.clear();
  content_.textures.clear();
  content_.materials_reception = Reception();
  content_.textures_reception = Reception();
}

void MeshInbox::clearLabels()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  content_.labels.clear();
  content_.labels_reception = Reception();
}

}  // namespace rviz_mesh_plugin
