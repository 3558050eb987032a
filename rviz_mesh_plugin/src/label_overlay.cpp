#include "rviz_mesh_plugin/label_overlay.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>

#include "rviz_mesh_plugin/label_layers.h"
#include "rviz_mesh_plugin/label_material.h"
#include "rviz_mesh_plugin/label_object.h"
#include "rviz_mesh_plugin/label_order.h"
#include "rviz_mesh_plugin/label_vertices.h"
#include "rviz_mesh_plugin/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

/// Bytes that are uploaded between two looks at the clock.
constexpr std::size_t SLICE = 1 << 20;

/// A call costs as much as so many bytes.
constexpr std::size_t CALL = 64;

const Rgba8 DEFAULT_COLOR{200, 200, 200, 255};
const Rgba8 PHANTOM_COLOR{51, 76, 51, 26};

}  // namespace

class LabelOverlay::Scene
{
 public:
  Scene(Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent)
      : parent_(parent), node_(scene_manager->createSceneNode())
  {
    parent_->addChild(node_);
  }

  ~Scene()
  {
    phantom_.reset();
    labels_.clear();
    destroySceneNode(node_);
  }

  void setMesh(const MeshDataConstPtr& mesh)
  {
    phantom_.reset();
    labels_.clear();
    waiting_.clear();
    vertices_.setMesh(mesh);
    layers_.reset(mesh ? mesh->faceCount() : 0);
    has_layers_ = false;
    if (phantom_shown_) {
      setPhantom(true);
    }
  }

  std::size_t setLabel(const LabelCluster& label)
  {
    const MeshDataConstPtr& mesh = vertices_.shared().mesh;
    const std::size_t face_count = mesh ? mesh->faceCount() : 0;
    const std::vector<std::uint32_t>* faces = &label.faces;
    std::vector<std::uint32_t> checked;
    std::size_t beyond = 0;
    const auto unordered = [](std::uint32_t a, std::uint32_t b) { return a >= b; };
    if (std::adjacent_find(faces->begin(), faces->end(), unordered) != faces->end() ||
        (!faces->empty() && faces->back() >= face_count)) {
      checked = label.faces;
      std::sort(checked.begin(), checked.end());
      const auto end = std::lower_bound(checked.begin(), checked.end(), face_count);
      beyond = static_cast<std::size_t>(checked.end() - end);
      checked.erase(end, checked.end());
      checked.erase(std::unique(checked.begin(), checked.end()), checked.end());
      faces = &checked;
    }
    if (faces->empty()) {
      removeLabel(label.label);
      return beyond;
    }
    std::unique_ptr<LabelObject>& object = labels_[label.label];
    if (!object) {
      object = std::make_unique<LabelObject>(node_, vertices_.shared());
      applyLook(label.label, *object);
    }
    layers_.remove(object->faces());
    object->setFaces(*faces);
    layers_.add(object->faces());
    is_arranged_ = false;
    waiting_.insert(label.label);
    return beyond;
  }

  void removeLabel(const std::string& label)
  {
    const auto known = labels_.find(label);
    if (known != labels_.end()) {
      layers_.remove(known->second->faces());
      labels_.erase(known);
      waiting_.erase(label);
      is_arranged_ = false;
    }
  }

  void setColor(const std::string& label, const Rgba8& color)
  {
    looks_[label].color = color;
    reapplyLook(label);
  }

  void setVisible(const std::string& label, bool visible)
  {
    looks_[label].visible = visible;
    reapplyLook(label);
  }

  void setAlpha(float alpha) { materials_.setAlpha(alpha); }

  void setPhantom(bool shown)
  {
    phantom_shown_ = shown;
    phantom_.reset();
    const MeshDataConstPtr& mesh = vertices_.shared().mesh;
    if (shown && mesh && mesh->faceCount() > 0) {
      phantom_ = std::make_unique<LabelObject>(node_, vertices_.shared());
      phantom_->setMaterial(std::make_shared<LabelMaterial>(PHANTOM_COLOR));
      std::vector<std::uint32_t> all(mesh->faceCount());
      std::iota(all.begin(), all.end(), 0u);
      phantom_->setFaces(all, false);
    }
  }

  void setPose(const Ogre::Vector3& position, const Ogre::Quaternion& orientation)
  {
    node_->setPosition(position);
    node_->setOrientation(orientation);
  }

  void setVisible(bool visible)
  {
    const bool attached = node_->getParent() != nullptr;
    if (visible && !attached) {
      parent_->addChild(node_);
    } else if (!visible && attached) {
      parent_->removeChild(node_);
    }
  }

  bool upload(std::chrono::microseconds budget)
  {
    const auto end = std::chrono::steady_clock::now() + budget;
    arrange();
    try {
      do {
        if (!uploadSlice()) {
          return true;
        }
      } while (std::chrono::steady_clock::now() < end);
    } catch (...) {
      waiting_.clear();
      phantom_.reset();
      vertices_.giveUp();
      throw;
    }
    return false;
  }

  std::size_t gpuBytes() const
  {
    std::size_t bytes = vertices_.gpuBytes() + (phantom_ ? phantom_->gpuBytes() : 0);
    for (const auto& label : labels_) {
      bytes += label.second->gpuBytes();
    }
    return bytes;
  }

  std::size_t uploadedBytes() const { return uploaded_bytes_; }

 private:
  struct Look
  {
    Rgba8 color = DEFAULT_COLOR;
    bool visible = true;
  };

  void applyLook(const std::string& label, LabelObject& object)
  {
    const Look& look = looks_[label];
    object.setMaterial(materials_.get(look.color));
    object.setShown(look.visible);
  }

  void reapplyLook(const std::string& label)
  {
    const auto object = labels_.find(label);
    if (object != labels_.end()) {
      applyLook(label, *object->second);
    }
  }

  /// Puts labels that share faces in layers, in the order of their names.
  void arrange()
  {
    if (is_arranged_ || (!layers_.overlap() && !has_layers_)) {
      return;
    }
    std::vector<const LabelLayers::Faces*> faces;
    for (const auto& label : labels_) {
      faces.push_back(&label.second->faces());
    }
    const std::vector<unsigned short> layers = layers_.layers(faces);
    std::size_t i = 0;
    for (const auto& label : labels_) {
      label.second->setLayer(layers[i++]);
    }
    has_layers_ = layers_.overlap();
    is_arranged_ = true;
  }

  /// False where there was nothing to do.
  bool uploadSlice()
  {
    if (!vertices_.shared().mesh || (labels_.empty() && !phantom_)) {
      return false;
    }
    if (!vertices_.shared().complete()) {
      uploaded_bytes_ += vertices_.upload(SLICE);
      return true;
    }
    std::size_t left = SLICE;
    while (!waiting_.empty() && left >= CALL) {
      LabelObject& object = *labels_.at(*waiting_.begin());
      const std::size_t bytes = object.upload(left);
      uploaded_bytes_ += bytes;
      left -= std::min(left, bytes + CALL);
      if (object.isComplete()) {
        waiting_.erase(waiting_.begin());
      }
    }
    if (left >= CALL && phantom_ && !phantom_->isComplete()) {
      uploaded_bytes_ += phantom_->upload(left);
      return true;
    }
    return left < SLICE;
  }

  Ogre::SceneNode* parent_;
  Ogre::SceneNode* node_;
  LabelMaterials materials_;
  LabelVertices vertices_;
  std::map<std::string, std::unique_ptr<LabelObject>, LabelLess> labels_;
  std::map<std::string, Look> looks_;
  std::set<std::string> waiting_;  ///< labels with something to upload
  std::unique_ptr<LabelObject> phantom_;
  bool phantom_shown_ = false;
  LabelLayers layers_;
  bool has_layers_ = false;
  bool is_arranged_ = true;
  std::size_t uploaded_bytes_ = 0;
};

LabelOverlay::LabelOverlay(Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent)
    : scene_(std::make_unique<Scene>(scene_manager, parent))
{
}

LabelOverlay::~LabelOverlay() = default;

void LabelOverlay::setMesh(const MeshDataConstPtr& mesh)
{
  scene_->setMesh(mesh);
}

std::size_t LabelOverlay::setLabel(const LabelCluster& label)
{
  return scene_->setLabel(label);
}

void LabelOverlay::removeLabel(const std::string& label)
{
  scene_->removeLabel(label);
}

void LabelOverlay::setColor(const std::string& label, const Rgba8& color)
{
  scene_->setColor(label, color);
}

void LabelOverlay::setVisible(const std::string& label, bool visible)
{
  scene_->setVisible(label, visible);
}

void LabelOverlay::setAlpha(float alpha)
{
  scene_->setAlpha(alpha);
}

void LabelOverlay::setPhantom(bool shown)
{
  scene_->setPhantom(shown);
}

void LabelOverlay::setPose(const Ogre::Vector3& position, const Ogre::Quaternion& orientation)
{
  scene_->setPose(position, orientation);
}

void LabelOverlay::setVisible(bool visible)
{
  scene_->setVisible(visible);
}

bool LabelOverlay::upload(std::chrono::microseconds budget)
{
  return scene_->upload(budget);
}

std::size_t LabelOverlay::gpuBytes() const
{
  return scene_->gpuBytes();
}

std::size_t LabelOverlay::uploadedBytes() const
{
  return scene_->uploadedBytes();
}

}  // namespace rviz_mesh_plugin
