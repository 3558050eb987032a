#include "rviz_mesh_plugin/label_overlay.h"

#include <cstdint>
#include <numeric>
#include <vector>

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>

#include "rviz_mesh_plugin/label_faces.h"
#include "rviz_mesh_plugin/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

/// Bytes that are uploaded between two looks at the clock.
constexpr std::size_t SLICE = 1 << 20;

const Rgba8 PHANTOM_COLOR{51, 76, 51, 26};

}  // namespace

LabelOverlay::LabelOverlay(Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent)
    : parent_(parent), node_(scene_manager->createSceneNode()), labels_(node_, vertices_.shared())
{
  parent_->addChild(node_);
}

LabelOverlay::~LabelOverlay()
{
  phantom_.reset();
  labels_.clear();
  destroySceneNode(node_);
}

void LabelOverlay::setMesh(const MeshDataConstPtr& mesh)
{
  phantom_.reset();
  labels_.clear();
  vertices_.setMesh(mesh);
  if (phantom_shown_) {
    setPhantom(true);
  }
}

std::size_t LabelOverlay::setLabel(const LabelClusterConstPtr& label)
{
  const MeshDataConstPtr& mesh = vertices_.shared().mesh;
  const LabelClusterConstPtr inside = withinMesh(label, mesh ? mesh->faceCount() : 0);
  if (inside->faces.empty()) {
    labels_.remove(label->label);
  } else {
    labels_.set(inside);
    applyLook(label->label);
  }
  return label->faces.size() - inside->faces.size();
}

void LabelOverlay::removeLabel(const std::string& label)
{
  labels_.remove(label);
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
  if (LabelObject* object = labels_.find(label)) {
    const Look& look = looks_[label];
    object->setMaterial(materials_.get(look.color));
    object->setShown(look.visible);
  }
}

void LabelOverlay::setPhantom(bool shown)
{
  phantom_shown_ = shown;
  phantom_.reset();
  const MeshDataConstPtr& mesh = vertices_.shared().mesh;
  if (shown && mesh && mesh->faceCount() > 0) {
    phantom_ = std::make_unique<LabelObject>(node_, vertices_.shared(), false);
    phantom_->setMaterial(std::make_shared<LabelMaterial>(PHANTOM_COLOR));
    auto all = std::make_shared<LabelSlots::Faces>(mesh->faceCount());
    std::iota(all->begin(), all->end(), 0u);
    phantom_->setFaces(all);
  }
}

void LabelOverlay::setPose(const Ogre::Vector3& position, const Ogre::Quaternion& orientation)
{
  node_->setPosition(position);
  node_->setOrientation(orientation);
}

void LabelOverlay::setVisible(bool visible)
{
  const bool attached = node_->getParent() != nullptr;
  if (visible && !attached) {
    parent_->addChild(node_);
  } else if (!visible && attached) {
    parent_->removeChild(node_);
  }
}

bool LabelOverlay::upload(std::chrono::microseconds budget)
{
  const auto end = std::chrono::steady_clock::now() + budget;
  try {
    do {
      if (!uploadSlice()) {
        return true;
      }
    } while (std::chrono::steady_clock::now() < end);
  } catch (...) {
    labels_.giveUp();
    phantom_.reset();
    vertices_.giveUp();
    throw;
  }
  return false;
}

/// False where there was nothing to do.
bool LabelOverlay::uploadSlice()
{
  if (!vertices_.shared().mesh || (labels_.empty() && !phantom_)) {
    return false;
  }
  if (!vertices_.shared().complete()) {
    uploaded_bytes_ += vertices_.upload(SLICE);
    return true;
  }
  std::size_t left = SLICE;
  uploaded_bytes_ += labels_.upload(left);
  if (left > 0 && phantom_ && !phantom_->isComplete()) {
    uploaded_bytes_ += phantom_->upload(left);
  }
  return left < SLICE;
}

std::size_t LabelOverlay::gpuBytes() const
{
  return vertices_.gpuBytes() + labels_.gpuBytes() + (phantom_ ? phantom_->gpuBytes() : 0);
}

}  // namespace rviz_mesh_plugin
