#include "selection/selection_visual.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include <OgreRenderQueue.h>

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

SelectionVisual::SelectionVisual(Ogre::SceneNode* parent)
    : PlacedVisual(parent), material_(std::make_shared<LabelMaterial>(COLOR))
{
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
    object_ = std::make_unique<SelectionObject>(node(), vertices_);
    object_->useMaterial(material_);
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
    object_->useMaterial(material);
  }
  material_ = std::move(material);
}

bool SelectionVisual::follow(const std::vector<ShownMesh>& shown)
{
  const auto found = std::find_if(shown.begin(), shown.end(), [&](const ShownMesh& other) {
    return mesh() && other.mesh == mesh();
  });
  place(found == shown.end() ? std::nullopt : std::make_optional<FramePose>(*found));
  return found != shown.end();
}

bool SelectionVisual::upload(std::chrono::microseconds budget)
{
  const auto end = std::chrono::steady_clock::now() + budget;
  try {
    while (mesh() && !vertices_.complete()) {
      vertices_.upload(SLICE);
      if (std::chrono::steady_clock::now() >= end) {
        break;
      }
    }
  } catch (...) {
    setMesh(nullptr);
    throw;
  }
  return !mesh() || vertices_.complete();
}

std::size_t SelectionVisual::gpuBytes() const
{
  return vertices_.gpuBytes() + (object_ ? object_->gpuBytes() : 0);
}

}  // namespace rviz_mesh_plugin
