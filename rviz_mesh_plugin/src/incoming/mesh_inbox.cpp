#include "incoming/mesh_inbox.h"

#include <algorithm>
#include <exception>
#include <unordered_map>
#include <utility>

#include "conversion/attribute_conversion.h"
#include "conversion/material_conversion.h"

namespace rviz_mesh_plugin {
namespace {

/// More than this is not kept while nobody takes it; the oldest goes.
constexpr std::size_t MAX_LABEL_SETS = 256;
constexpr std::size_t MAX_MESHES = 8;
constexpr std::size_t MAX_TEXTURES = 4096;

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
void eraseSets(Items& items, const IsGone& is_gone)
{
  items.erase(std::remove_if(items.begin(), items.end(), is_gone), items.end());
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
    eraseSets(sets, [&](const auto& other) { return other->uuid == labels->uuid; });
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
bool MeshInbox::change(const Edit& edit, const Flag* dropped)
{
  const std::lock_guard<std::mutex> changing(changing_);
  while (true) {
    InboxContent next;  // what it replaces is freed without the lock
    std::uint64_t version = 0;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      next = content_;
      version = version_;
    }
    edit(next);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (dropped != nullptr && *dropped) {
      return false;
    }
    if (version == version_) {
      std::swap(content_, next);
      return true;
    }
  }
}

template <class Convert, class Store>
bool MeshInbox::accept(const Convert& convert, Reception InboxContent::*reception,
                       const Store& store, const Flag* dropped)
{
  std::string refusal;
  decltype(convert()) converted;
  try {
    converted = convert();
    return change(
        [&](InboxContent& content) {
          (content.*reception).accept();
          store(content, converted);
        },
        dropped);
  } catch (const RejectedMessage& rejected) {
    refusal = rejected.what();
  } catch (const std::exception& error) {  // out of memory
    refusal = std::string("the message could not be ") + (converted ? "kept" : "converted") + ": " +
              error.what();
  }
  refuse(reception, refusal, dropped);
  return false;
}

void MeshInbox::refuse(Reception InboxContent::*reception, const std::string& reason,
                       const Flag* dropped)
{
  change([&](InboxContent& content) { (content.*reception).refuse(reason); }, dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshVertexCostsStamped& message, const Flag* dropped)
{
  const auto store = [outdated = message.header.stamp.toNSec()](InboxContent& content,
                                                                const auto& layer) {
    layer->outdated = outdated;  // as it was; add() may have changed it
    content.add(layer);
  };
  return accept([&]() { return convert(message); }, &InboxContent::costs_reception, store, dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshFaceCostsStamped& message, const Flag* dropped)
{
  return accept([&]() { return convert(message); }, &InboxContent::face_costs_reception,
                [](InboxContent& content, const auto& layer) { content.add(layer); }, dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshVertexCostsSparseStamped& message, const Flag* dropped)
{
  return accept([&]() { return convert(message); }, &InboxContent::updates_reception,
                [](InboxContent& content, const auto& update) { content.add(update); }, dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshVertexColorsStamped& message, const Flag* dropped)
{
  const auto store = [](InboxContent& content, const ColorLayerConstPtr& layer) {
    replaceOrAppend(content.colors, layer, MAX_MESHES,
                    [&](const ColorLayerConstPtr& other) { return other->uuid == layer->uuid; });
  };
  return accept([&]() { return convert(message); }, &InboxContent::colors_reception, store,
                dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshMaterialsStamped& message, const Flag* dropped)
{
  const auto store = [](InboxContent& content, const MaterialsConstPtr& materials) {
    replaceOrAppend(content.materials, materials, MAX_MESHES,
                    [&](const MaterialsConstPtr& other) { return other->uuid == materials->uuid; });
  };
  return accept([&]() { return convert(message); }, &InboxContent::materials_reception, store,
                dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshTexture& message, const Flag* dropped)
{
  const auto store = [](InboxContent& content, const TextureImageConstPtr& image) {
    replaceOrAppend(content.textures, image, MAX_TEXTURES, [&](const TextureImageConstPtr& other) {
      return other->uuid == image->uuid && other->index == image->index;
    });
  };
  return accept([&]() { return convert(message); }, &InboxContent::textures_reception, store,
                dropped);
}

bool MeshInbox::receive(const mesh_msgs::MeshFaceCluster& message, const Flag* dropped)
{
  const auto store = [](InboxContent& content, const LabelSetConstPtr& labels) {
    addLabels(content.labels, labels);
  };
  return accept([&]() { return convert(message); }, &InboxContent::labels_reception, store,
                dropped);
}

bool MeshInbox::receiveLabels(const std::string& uuid,
                              const std::vector<mesh_msgs::MeshFaceCluster>& clusters, bool all,
                              const Flag* dropped)
{
  std::string left_out;
  const auto store = [&left_out](InboxContent& content, const LabelSetConstPtr& labels) {
    addLabels(content.labels, labels);
    content.labels_reception.refusal = left_out;
  };
  return accept([&]() { return convertLabels(uuid, clusters, all, left_out); },
                &InboxContent::labels_reception, store, dropped);
}

InboxContent MeshInbox::take()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ++version_;
  InboxContent taken = std::move(content_);
  content_ = InboxContent();
  content_.stale = taken.stale;
  content_.costs_reception = taken.costs_reception;
  content_.face_costs_reception = taken.face_costs_reception;
  content_.updates_reception = taken.updates_reception;
  content_.colors_reception = taken.colors_reception;
  content_.materials_reception = taken.materials_reception;
  content_.textures_reception = taken.textures_reception;
  content_.labels_reception = taken.labels_reception;
  return taken;
}

template <class Forget>
void MeshInbox::forget(const Forget& forget)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ++version_;
  forget(content_);
}

void MeshInbox::clearCosts()
{
  forget([](InboxContent& content) {
    eraseSets(content.costs, [](const auto& layer) { return !layer->on_faces; });
    content.costs_reception = Reception();
  });
}

void MeshInbox::clearFaceCosts()
{
  forget([](InboxContent& content) {
    eraseSets(content.costs, [](const auto& layer) { return layer->on_faces; });
    content.face_costs_reception = Reception();
  });
}

void MeshInbox::clearUpdates()
{
  forget([](InboxContent& content) {
    content.earlier_updates.clear();
    content.updates.clear();
    content.stale = 0;
    content.updates_reception = Reception();
  });
}

void MeshInbox::clearColors()
{
  forget([](InboxContent& content) {
    content.colors.clear();
    content.colors_reception = Reception();
  });
}

void MeshInbox::clearMaterials()
{
  forget([](InboxContent& content) {
    content.materials.clear();
    content.textures.clear();
    content.materials_reception = Reception();
    content.textures_reception = Reception();
  });
}

void MeshInbox::clearLabels()
{
  forget([](InboxContent& content) {
    content.labels.clear();
    content.labels_reception = Reception();
  });
}

}  // namespace rviz_mesh_plugin
