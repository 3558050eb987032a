#include "rviz_mesh_plugin/label_objects.h"

#include <algorithm>

namespace rviz_mesh_plugin {
namespace {

/// A call costs as much as so many bytes.
constexpr std::size_t CALL = 64;

/// As much as to find the layer of so many faces.
constexpr std::size_t FACE_LAYER = 2;

}  // namespace

LabelObject& LabelObjects::set(const LabelClusterConstPtr& cluster)
{
  Label& label = labels_[cluster->label];
  if (!label.object) {
    label.object = std::make_unique<LabelObject>(parent_, mesh_);
  }
  label.cluster = cluster;
  label.object->setFaces({cluster, &cluster->faces});
  waiting_.insert(cluster->label);
  is_arranged_ = false;
  return *label.object;
}

void LabelObjects::remove(const std::string& label)
{
  if (labels_.erase(label) > 0) {
    waiting_.erase(label);
    is_arranged_ = false;
  }
}

void LabelObjects::clear()
{
  labels_.clear();
  waiting_.clear();
  layers_ = LabelLayers();
  is_arranged_ = true;
}

LabelObject* LabelObjects::find(const std::string& label) const
{
  const auto found = labels_.find(label);
  return found == labels_.end() ? nullptr : found->second.object.get();
}

std::size_t LabelObjects::upload(std::size_t& left)
{
  std::size_t half = left / 2;  // neither holds up the other
  left -= half;
  arrange(half);
  left += half;
  std::size_t uploaded = 0;
  while (!waiting_.empty() && left >= CALL) {
    LabelObject& object = *labels_.at(*waiting_.begin()).object;
    uploaded += object.upload(left);
    left -= std::min(left, CALL);
    if (object.isComplete()) {
      waiting_.erase(waiting_.begin());
    }
  }
  return uploaded;
}

/// Finds the layers of the labels as they are when it begins: others that come meanwhile are for
/// the next time, so that labels that change all the time get theirs, too.
void LabelObjects::arrange(std::size_t& left)
{
  if (!is_arranged_ && layers_.isDone()) {
    is_arranged_ = true;
    LabelLayers::Labels clusters;
    clusters.reserve(labels_.size());
    for (const auto& label : labels_) {
      clusters.push_back(label.second.cluster);
    }
    layers_.start(mesh_.mesh->faceCount(), std::move(clusters));
  }
  const auto place = [this](const LabelCluster& label, unsigned short layer) {
    if (LabelObject* object = find(label.label)) {
      object->setLayer(layer);
    }
  };
  const std::size_t looked = layers_.work(left / FACE_LAYER, place);
  left -= std::min(left, FACE_LAYER * looked);
}

std::size_t LabelObjects::gpuBytes() const
{
  std::size_t bytes = 0;
  for (const auto& label : labels_) {
    bytes += label.second.object->gpuBytes();
  }
  return bytes;
}

}  // namespace rviz_mesh_plugin
