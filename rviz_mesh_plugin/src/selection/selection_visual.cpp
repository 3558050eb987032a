#include "selection/selection_visual.h"

#include <cstdint>

#include <OgreRenderQueue.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>

#include "rendering/labels/label_material.h"
#include "rendering/labels/label_object.h"

namespace rviz_mesh_plugin {
namespace {

/// Bytes of vertices that are uploaded between two looks at the clock.
constexpr std::size_t SLICE = 1 << 20;

/// After translucent labels.
constexpr Ogre::uint8 AFTER_LABELS = Ogre::RENDER_QUEUE_MAIN + 2;

class SelectionObject : public LabelObject
{
 public:
  using LabelObject::LabelObject;

  void _updateRenderQueue(Ogre::RenderQueue* queue) override
  {
    queue->addRenderable(this, AFTER_LABELS, OGRE_RENDERABLE_DEFAULT_PRIORITY);
  }
};

}  // namespace

SelectionVisual::SelectionVisual(Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent)
    : parent_(parent),
      node_(scene_manager->createSceneNode()),
      material_(std::make_shared<LabelMaterial>(COLOR))
{
  parent_->addChild(node_);
}

SelectionVisual::~SelectionVisual()
{
  object_.reset();
  destroySceneNode(node_);
}

void SelectionVisual::setMesh(const MeshDataConstPtr& mesh)
{
  object_.reset();
  vertices_.setMesh(mesh);
  makeObject();
}

/// Without any faces.
void SelectionVisual::makeObject()
{
  object_.reset();
  if (mesh()) {
    object_ = std::make_unique<SelectionObject>(node_, vertices_.shared());
    object_->setMaterial(material_);
  }
}

void SelectionVisual::setSelection(const FaceSelection& selection)
{
  makeObject();
  FaceSelection::Change change;
  change.added = selection.faces();
  apply(change);
}

void SelectionVisual::apply(const FaceSelection::Change& change)
{
  if (!object_ || change.empty()) {
    return;
  }
  try {
    uploaded_bytes_ += object_->changeFaces(change.added, change.removed);
  } catch (...) {
    makeObject();
    throw;
  }
}

void SelectionVisual::setColor(const Rgba8& color)
{
  auto material = std::make_shared<LabelMaterial>(color);
  if (object_) {
    object_->setMaterial(material);
  }
  material_ = std::move(material);
}

void SelectionVisual::setVisible(bool visible)
{
  const bool attached = node_->getParent() != nullptr;
  if (visible && !attached) {
    parent_->addChild(node_);
  } else if (!visible && attached) {
    parent_->removeChild(node_);
  }
}

bool SelectionVisual::follow(const std::vector<ShownMesh>& shown)
{
  for (const ShownMesh& other : shown) {
    if (mesh() && other.mesh == mesh()) {
      node_->setPosition(other.position);
      node_->setOrientation(other.orientation);
      setVisible(true);
      return true;
    }
  }
  setVisible(false);
  return false;
}

bool SelectionVisual::upload(std::chrono::microseconds budget)
{
  const auto end = std::chrono::steady_clock::now() + budget;
  try {
    while (mesh() && !vertices_.shared().complete()) {
      vertices_.upload(SLICE);
      if (std::chrono::steady_clock::now() >= end) {
        break;
      }
    }
  } catch (...) {
    setMesh(nullptr);
    throw;
  }
  return !mesh() || vertices_.shared().complete();
}

std::size_t SelectionVisual::gpuBytes() const
{
  return vertices_.gpuBytes() + (object_ ? object_->gpuBytes() : 0);
}

}  // namespace rviz_mesh_plugin
