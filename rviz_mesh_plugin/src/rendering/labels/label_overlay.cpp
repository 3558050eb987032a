#include "rendering/labels/label_overlay.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include "labels/label_faces.h"

namespace rviz_mesh_plugin {
namespace {

/// Bytes that are uploaded between two looks at the clock.
constexpr std::size_t SLICE = 1 << 20;

const Rgba8 PHANTOM_COLOR{51, 76, 51, 26};

/// A call costs as much as so many bytes.
constexpr std::size_t CALL = 64;

/// A label of less faces is drawn as they are, however many labels there are.
constexpr std::size_t FEW_FACES = 256;

/// As much as to find the layer of so many faces.
constexpr std::size_t FACE_LAYER = 2;

}  // namespace

void LabelOverlay::setMesh(const MeshDataConstPtr& mesh)
{
  phantom_.reset();
  hidden_.reset();
  labels_.clear();
  face_count_ = 0;
  waiting_.clear();
  layers_ = LabelLayers();
  is_arranged_ = true;
  vertices_.setMesh(mesh);
  if (phantom_shown_) {
    setPhantom(true);
  }
}

std::size_t LabelOverlay::setLabel(const LabelClusterConstPtr& cluster)
{
  const MeshDataConstPtr& mesh = vertices_.mesh();
  const LabelClusterConstPtr inside = withinMesh(cluster, mesh ? mesh->faceCount() : 0);
  if (inside->faces.empty()) {
    removeLabel(cluster->label);
  } else {
    auto known = labels_.find(cluster->label);
    if (known == labels_.end()) {
      Label made{inside, std::make_unique<LabelObject>(node(), vertices_)};
      known = labels_.emplace(cluster->label, std::move(made)).first;
    } else {
      face_count_ -= known->second.cluster->faces.size();
    }
    Label& label = known->second;
    label.cluster = inside;
    face_count_ += inside->faces.size();
    setFaces(label);
    waiting_.insert(cluster->label);
    is_arranged_ = false;
    applyLook(cluster->label);
  }
  return cluster->faces.size() - inside->faces.size();
}

/// Few are drawn as they are; of many, the thread makes what is drawn.
void LabelOverlay::setFaces(Label& label)
{
  const std::shared_ptr<const IndexSlots::Faces> faces{label.cluster, &label.cluster->faces};
  const bool in_parts = face_count_ > MANY_FACES && faces->size() > FEW_FACES;
  label.object->setFaces(faces, in_parts, hidden_);
}

void LabelOverlay::setHidden(const HiddenFacesConstPtr& hidden)
{
  if (hidden == hidden_) {
    return;
  }
  const HiddenFacesConstPtr before = std::exchange(hidden_, hidden);
  if (!vertices_.mesh()) {
    return;  // it could not be uploaded
  }
  // To look at more faces takes as long as to have them drawn anew.
  const auto differs = [&](const std::vector<std::uint32_t>& faces) {
    return faces.size() > MANY_FACES ||
           std::any_of(faces.begin(), faces.end(), [&](std::uint32_t face) {
             return (before && before->contains(face)) != (hidden && hidden->contains(face));
           });
  };
  for (auto& label : labels_) {
    if (differs(label.second.cluster->faces)) {
      setFaces(label.second);
      waiting_.insert(label.first);
    }
  }
  if (phantom_) {
    setPhantomFaces();
  }
}

void LabelOverlay::removeLabel(const std::string& label)
{
  const auto found = labels_.find(label);
  if (found != labels_.end()) {
    face_count_ -= found->second.cluster->faces.size();
    labels_.erase(found);
    waiting_.erase(label);
    is_arranged_ = false;
  }
}

LabelObject* LabelOverlay::find(const std::string& label) const
{
  const auto found = labels_.find(label);
  return found == labels_.end() ? nullptr : found->second.object.get();
}

void LabelOverlay::setColor(const std::string& label, const Rgba8& color)
{
  looks_[label].color = color;
  applyLook(label);
}

void LabelOverlay::setVisible(const std::string& label, bool visible)
{
  looks_[label].visible = visible;
  applyLook(label);
}

void LabelOverlay::applyLook(const std::string& label)
{
  if (LabelObject* object = find(label)) {
    const LabelLook& look = looks_[label];
    object->useMaterial(materials_.get(look.color));
    object->setShown(look.visible);
  }
}

void LabelOverlay::setPhantom(bool shown)
{
  phantom_shown_ = shown;
  phantom_.reset();
  const MeshDataConstPtr& mesh = vertices_.mesh();
  if (shown && mesh && mesh->faceCount() > 0) {
    phantom_ = std::make_unique<LabelObject>(node(), vertices_, false);
    phantom_material_ = std::make_shared<LabelMaterial>(PHANTOM_COLOR, materials_.section());
    phantom_->useMaterial(phantom_material_);
    setPhantomFaces();
  }
}

void LabelOverlay::setPhantomFaces()
{
  FaceBits all(vertices_.mesh()->faceCount());
  all.addAll();
  if (hidden_) {
    all.remove(hidden_->bits());
  }
  if (all.size() > MANY_FACES) {
    phantom_->setFaces(std::make_shared<const FaceBits>(std::move(all)));
  } else {
    phantom_->setFaces(std::make_shared<const IndexSlots::Faces>(all.faces()));
  }
}

void LabelOverlay::setSection(const Section& section)
{
  if (section != materials_.section()) {
    materials_.setSection(section);
    if (phantom_material_) {
      phantom_material_->setSection(section);
    }
  }
}

bool LabelOverlay::upload(std::chrono::microseconds budget)
{
  const auto end = std::chrono::steady_clock::now() + budget;
  try {
    do {
      if (!uploadSlice()) {
        return waiting_.empty() && (!phantom_ || phantom_->isComplete());  // else for threads
      }
    } while (std::chrono::steady_clock::now() < end);
  } catch (...) {
    waiting_.clear();  // what has not been uploaded yet stays so
    phantom_.reset();
    vertices_.setMesh(nullptr);
    throw;
  }
  return false;
}

/// False where there was nothing to do.
bool LabelOverlay::uploadSlice()
{
  if (!vertices_.mesh() || (labels_.empty() && !phantom_)) {
    return false;
  }
  if (!vertices_.complete()) {
    uploaded_bytes_ += vertices_.upload(SLICE);
    return true;
  }
  std::size_t left = SLICE;
  uploaded_bytes_ += uploadLabels(left);
  if (left > 0 && phantom_ && !phantom_->isWaiting()) {
    uploaded_bytes_ += phantom_->upload(left);
  }
  return left < SLICE;
}

/// Works as long as uploading @a left bytes takes, and takes that off it; returns how many bytes
/// were uploaded. All of it is left where there is nothing to do.
std::size_t LabelOverlay::uploadLabels(std::size_t& left)
{
  std::size_t half = left / 2;  // neither holds up the other
  left -= half;
  arrange(half);
  left += half;
  std::size_t uploaded = 0;
  for (auto label = waiting_.begin(); label != waiting_.end() && left >= CALL;) {
    LabelObject& object = *labels_.at(*label).object;
    if (object.isWaiting() && !object.isComplete()) {
      ++label;  // for its thread, which others do not have to
      continue;
    }
    uploaded += object.upload(left);
    left -= std::min(left, CALL);
    if (object.isComplete()) {
      label = waiting_.erase(label);
    }
  }
  return uploaded;
}

/// Finds the layers of the labels as they are when it begins: others that come meanwhile are for
/// the next time, so that labels that change all the time get theirs, too.
void LabelOverlay::arrange(std::size_t& left)
{
  if (!is_arranged_ && layers_.isDone()) {
    is_arranged_ = true;
    LabelLayers::Labels clusters;
    clusters.reserve(labels_.size());
    for (const auto& label : labels_) {
      clusters.push_back(label.second.cluster);
    }
    layers_.start(vertices_.mesh()->faceCount(), std::move(clusters));
  }
  const auto place = [this](const LabelCluster& label, unsigned short layer) {
    if (LabelObject* object = find(label.label)) {
      object->setLayer(layer);
    }
  };
  const std::size_t looked = layers_.work(left / FACE_LAYER, place);
  left -= std::min(left, FACE_LAYER * looked);
}

std::size_t LabelOverlay::facesDrawn() const
{
  return std::accumulate(
      labels_.begin(), labels_.end(), std::size_t{0},
      [](std::size_t sum, const auto& label) { return sum + label.second.object->facesDrawn(); });
}

std::size_t LabelOverlay::gpuBytes() const
{
  std::size_t bytes = vertices_.gpuBytes() + (phantom_ ? phantom_->gpuBytes() : 0);
  for (const auto& label : labels_) {
    bytes += label.second.object->gpuBytes();
  }
  return bytes;
}

}  // namespace rviz_mesh_plugin
