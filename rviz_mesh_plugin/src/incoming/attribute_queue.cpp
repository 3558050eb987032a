#include "incoming/attribute_queue.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <unordered_map>
#include <utility>

#include "base/erase_if.h"
#include "conversion/attribute_conversion.h"
#include "conversion/material_conversion.h"

namespace rviz_mesh_plugin {
namespace {

/// More than this is not kept while nobody takes it; the oldest goes.
constexpr std::size_t MAX_LABEL_SETS = 256;
constexpr std::size_t MAX_MESHES = 8;
/// Where updates have more than this part of the values of a layer, it counts as new.
constexpr std::size_t MANY_CHANGES = 16;

/// Puts @a item behind the others, in place of the one that it supersedes.
template <class Pointer, class IsSame>
void replaceOrAppend(std::vector<Pointer>& items, const Pointer& item, std::size_t most,
                     const IsSame& is_same)
{
  eraseIf(items, is_same);
  items.push_back(item);
  if (items.size() > most) {
    items.erase(items.begin());
  }
}

/// The same, up to so many bytes; the new one in any case.
template <class Pointer, class IsSame>
void replaceOrAppendBytes(std::vector<Pointer>& items, const Pointer& item, std::size_t most,
                          const IsSame& is_same)
{
  replaceOrAppend(items, item, items.size() + 1, is_same);
  std::size_t sum = 0;
  auto first = items.end();
  while (first != items.begin() && (sum == 0 || sum + (*std::prev(first))->bytes() <= most)) {
    sum += (*--first)->bytes();
  }
  items.erase(items.begin(), first);
}

template <class Layer>
bool isOf(const ChangedCosts& changed, const Layer& layer)
{
  return changed.layer->uuid == layer.uuid && changed.layer->type == layer.type;
}

/// What updates of it have brought before is in a layer of vertices already, or does not count.
void addCosts(QueuedAttributes& content, const CostLayerConstPtr& layer, std::size_t most)
{
  if (!layer->on_faces) {
    eraseIf(content.changed_costs, [&](const auto& changed) { return isOf(changed, *layer); });
  }
  replaceOrAppendBytes(content.costs, layer, most, [&](const auto& other) {
    return other->uuid == layer->uuid && other->type == layer->type &&
           other->on_faces == layer->on_faces;
  });
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

void addLabels(std::vector<LabelSetConstPtr>& sets, const LabelSetConstPtr& labels)
{
  if (labels->all) {
    eraseIf(sets, [&](const auto& other) { return other->uuid == labels->uuid; });
  }
  sets.push_back(labels);
  if (sets.size() > MAX_LABEL_SETS) {
    joinLabels(sets);
  }
  if (sets.size() > MAX_LABEL_SETS) {
    sets.erase(sets.begin());
  }
}

}  // namespace

/// What the GUI thread does in the meantime counts: then all is done once more.
template <class Edit>
bool AttributeQueue::change(const Edit& edit, const Origin& origin)
{
  while (true) {
    QueuedAttributes next;  // what it replaces is freed without the lock
    std::uint64_t version = 0;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      next = content_;
      version = version_;
    }
    edit(next);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (origin.isDropped()) {
      return false;
    }
    if (version == version_) {
      std::swap(content_, next);
      return true;
    }
  }
}

/// @param arrange what is converted, once
template <class Convert, class Arrange, class Store>
bool AttributeQueue::accept(MeshMember part, const Convert& convert, const Arrange& arrange,
                            const Store& store, const Origin& origin)
{
  std::string refusal;
  decltype(convert()) converted;
  try {
    converted = convert();
    const std::lock_guard<std::mutex> changing(changing_);
    if (origin.isDropped()) {
      return false;
    }
    endMerging(false);  // of what has failed
    forgetOrder();
    arrange(converted);
    const bool kept = change(
        [&](QueuedAttributes& content) {
          content.receptions[part].accept(origin.service);
          store(content, converted);
        },
        origin);
    endMerging(kept);
    return kept;
  } catch (const RejectedMessage& rejected) {
    refusal = rejected.what();
  } catch (const std::exception& error) {  // out of memory
    refusal = std::string("the message could not be ") + (converted ? "kept" : "converted") + ": " +
              error.what();
  }
  refuse(part, refusal, origin);
  return false;
}

template <class Message, class Store>
bool AttributeQueue::accept(MeshMember part, const Message& message, const Store& store,
                            const Origin& origin)
{
  return accept(
      part, [&] { return convert(message); }, [](const auto& /*converted*/) {}, store, origin);
}

void AttributeQueue::refuse(MeshMember part, const std::string& reason, const Origin& origin)
{
  const std::lock_guard<std::mutex> changing(changing_);
  change(
      [&](QueuedAttributes& content) { content.receptions[part].refuse(reason, origin.service); },
      origin);
}

bool AttributeQueue::receive(const mesh_msgs::MeshVertexCostsStamped& message, const Origin& origin)
{
  std::string problem;
  return accept(
      MeshMember::COSTS, [&] { return convert(message); },
      [&](const auto& layer) {
        problem = order_.arrange(*layer);
        eraseIf(layers_, [](const auto& known) { return known.second.expired(); });
        layers_[{layer->uuid, layer->type}];  // so that nothing fails once it is kept
        coming_ = layer;
      },
      [&](QueuedAttributes& content, const auto& layer) {
        addCosts(content, layer, most_);
        if (!problem.empty()) {
          content.receptions[MeshMember::UPDATES].refusal = problem;
        }
        content.stale = order_.stale();
      },
      origin);
}

bool AttributeQueue::receive(const mesh_msgs::MeshFaceCostsStamped& message, const Origin& origin)
{
  const auto store = [this](QueuedAttributes& content, const CostLayerConstPtr& layer) {
    addCosts(content, layer, most_);
  };
  return accept(MeshMember::FACE_COSTS, message, store, origin);
}

bool AttributeQueue::receive(const mesh_msgs::MeshVertexCostsSparseStamped& message,
                             const Origin& origin)
{
  std::string problem;
  return accept(
      MeshMember::UPDATES, [&] { return convert(message); },
      [&](auto& update) {
        update = order_.arrange(update, problem);
        if (update) {
          problem = merge(update);
        }
        if (!problem.empty()) {
          endMerging(false);
          update = nullptr;
        }
      },
      [&](QueuedAttributes& content, const auto& update) {
        if (update) {
          content.changed_costs.push_back(merging_);
        }
        content.receptions[MeshMember::UPDATES].refusal = problem;
        content.stale = order_.stale();
      },
      origin);
}

/// Applies an update to its layer; returns why not, or an empty text.
std::string AttributeQueue::merge(const CostUpdateConstPtr& update)
{
  const auto known = layers_.find({update->uuid, update->type});
  std::shared_ptr<CostLayer> layer = known == layers_.end() ? nullptr : known->second.lock();
  if (!layer) {  // driven out by others, or lost with what was taken and not stored
    return "layer '" + update->type +
           "' is not kept any more: its updates count from when it comes again, whole";
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    auto& changed = content_.changed_costs;
    const auto found = std::find_if(changed.begin(), changed.end(),
                                    [&](const auto& other) { return isOf(other, *update); });
    if (found != changed.end()) {
      merging_ = std::move(*found);
      changed.erase(found);
    }
  }
  if (!merging_.layer) {  // the GUI thread may be reading the one before
    layer = std::make_shared<CostLayer>(*layer);
  }
  std::string misfit = applyUpdate(*layer, *update);
  if (!misfit.empty()) {
    return misfit;  // made for another layer, which has been dropped on the way
  }
  known->second = layer;
  merging_.layer = std::move(layer);
  merging_.values += update->vertices.size();
  if (merging_.values > merging_.layer->costs.size() / MANY_CHANGES) {
    merging_.updates.clear();
  } else {
    merging_.updates.push_back(update);
  }
  return {};
}

/// Puts it back where it is not in the content again.
void AttributeQueue::endMerging(bool kept)
{
  if (!kept && merging_.layer) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!layers_forgotten_) {
      content_.changed_costs.push_back(merging_);
    }
  }
  merging_ = ChangedCosts();
  if (const auto layer = std::exchange(coming_, nullptr); layer && kept) {
    layers_.find({layer->uuid, layer->type})->second = layer;
  }
}

bool AttributeQueue::receive(const mesh_msgs::MeshVertexColorsStamped& message,
                             const Origin& origin)
{
  const auto store = [](QueuedAttributes& content, const ColorLayerConstPtr& layer) {
    replaceOrAppend(content.colors, layer, MAX_MESHES,
                    [&](const ColorLayerConstPtr& other) { return other->uuid == layer->uuid; });
  };
  return accept(MeshMember::COLORS, message, store, origin);
}

bool AttributeQueue::receive(const mesh_msgs::MeshMaterialsStamped& message, const Origin& origin)
{
  const auto store = [](QueuedAttributes& content, const MaterialsConstPtr& materials) {
    replaceOrAppend(content.materials, materials, MAX_MESHES,
                    [&](const MaterialsConstPtr& other) { return other->uuid == materials->uuid; });
  };
  return accept(MeshMember::MATERIALS, message, store, origin);
}

bool AttributeQueue::receive(const mesh_msgs::MeshTexture& message, const Origin& origin)
{
  const auto store = [this](QueuedAttributes& content, const TextureImageConstPtr& image) {
    replaceOrAppendBytes(content.textures, image, most_, [&](const TextureImageConstPtr& other) {
      return other->uuid == image->uuid && other->index == image->index;
    });
  };
  return accept(MeshMember::TEXTURES, message, store, origin);
}

bool AttributeQueue::receive(const mesh_msgs::MeshFaceCluster& message, const Origin& origin)
{
  const auto store = [](QueuedAttributes& content, const LabelSetConstPtr& labels) {
    addLabels(content.labels, labels);
  };
  return accept(MeshMember::LABELS, message, store, origin);
}

bool AttributeQueue::receiveLabels(const std::string& uuid,
                                   const std::vector<mesh_msgs::MeshFaceCluster>& clusters,
                                   bool all, const Origin& origin)
{
  std::string left_out;
  return accept(
      MeshMember::LABELS, [&] { return convertLabels(uuid, clusters, all, left_out); },
      [](const auto& /*labels*/) {},
      [&](QueuedAttributes& content, const LabelSetConstPtr& labels) {
        addLabels(content.labels, labels);
        content.receptions[MeshMember::LABELS].refusal = left_out;
      },
      origin);
}

QueuedAttributes AttributeQueue::take()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ++version_;
  QueuedAttributes taken = std::move(content_);
  content_ = QueuedAttributes();
  content_.stale = taken.stale;
  content_.receptions = taken.receptions;
  return taken;
}

void AttributeQueue::forgetOrder()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (std::exchange(layers_forgotten_, false)) {
    order_.forgetLayers();
    layers_.clear();
  }
  if (std::exchange(updates_forgotten_, false)) {
    order_.forgetUpdates();
  }
}

void AttributeQueue::forget(MeshMember part)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ++version_;
  content_.receptions[part] = Reception();
  switch (part) {
    case MeshMember::GEOMETRY:
      break;
    case MeshMember::COSTS:
      eraseIf(content_.costs, [](const auto& layer) { return !layer->on_faces; });
      content_.changed_costs.clear();
      layers_forgotten_ = true;
      break;
    case MeshMember::FACE_COSTS:
      eraseIf(content_.costs, [](const auto& layer) { return layer->on_faces; });
      break;
    case MeshMember::UPDATES:
      content_.stale = 0;  // what updates have changed stays: nobody else has these layers
      updates_forgotten_ = true;
      break;
    case MeshMember::COLORS:
      content_.colors.clear();
      break;
    case MeshMember::MATERIALS:
    case MeshMember::TEXTURES:
      content_.materials.clear();
      content_.textures.clear();
      content_.receptions[MeshMember::MATERIALS] = Reception();
      content_.receptions[MeshMember::TEXTURES] = Reception();
      break;
    case MeshMember::LABELS:
      content_.labels.clear();
      break;
  }
}

}  // namespace rviz_mesh_plugin
