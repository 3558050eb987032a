#include "selection/selection_visual.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include <OgrePass.h>
#include <OgreRenderQueue.h>
#include <OgreTechnique.h>

#include "base/erase_if.h"

namespace rviz_mesh_plugin {
namespace {

/// Bytes of vertices that are uploaded between two looks at the clock.
constexpr std::size_t SLICE = 1 << 20;

/// After translucent labels.
constexpr Ogre::uint8 AFTER_LABELS = Ogre::RENDER_QUEUE_MAIN + 2;

/// In front of labels that lie on the same faces.
constexpr float DEPTH_BIAS = 2.0f;

/// What lies there twice, where levels of detail meet, is seen once: the second time it is not
/// nearer any more.
std::shared_ptr<LabelMaterial> makeMaterial(const Rgba8& color, const Section& section)
{
  auto material = std::make_shared<LabelMaterial>(color, section);
  for (unsigned short i = 0; i < material->get()->getNumTechniques(); ++i) {
    Ogre::Pass* pass = material->get()->getTechnique(i)->getPass(0);
    pass->setDepthWriteEnabled(true);
    pass->setDepthFunction(Ogre::CMPF_LESS);
    pass->setDepthBias(DEPTH_BIAS, DEPTH_BIAS);
  }
  return material;
}

class SelectionObject : public LabelObject
{
 public:
  using LabelObject::LabelObject;

  void _updateRenderQueue(Ogre::RenderQueue* queue) override
  {
    addTo(queue, AFTER_LABELS, OGRE_RENDERABLE_DEFAULT_PRIORITY);
  }
};

}  // namespace

SelectionVisual::SelectionVisual(Ogre::SceneNode* parent)
    : PlacedVisual(parent), material_(makeMaterial(COLOR, Section()))
{
}

void SelectionVisual::setMesh(const MeshDataConstPtr& mesh)
{
  object_.reset();
  preparing_.drop();
  levels_.reset();
  vertices_.setMesh(mesh);
  hidden_ = mesh ? hiddenFaces(*mesh) : nullptr;
  makeObject();
  if (mesh && mesh->faceCount() > MANY_FACES) {
    preparing_.start([mesh](const Cancellation& cancellation) {
      return OverlayLevels::of(mesh, cancellation.flag());
    });
  }
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
  FaceSelection none(selection.size());
  apply(selection, none.replaceBits(selection.bits()));
}

void SelectionVisual::apply(const FaceSelection& selection, const FaceSelection::Change& change)
{
  if (!object_ || change.empty()) {
    return;
  }
  const bool many = object_->inParts() || std::max(selection.count(), change.count()) > MANY_FACES;
  try {
    if (!many) {
      uploaded_bytes_ += object_->changeFaces(shownOf(change.added()), shownOf(change.removed()));
    } else if (selection.empty()) {
      makeObject();
    } else {
      FaceBits faces = selection.bits();
      if (hidden_) {
        faces.remove(hidden_->bits());
      }
      object_->setFaces(std::make_shared<const FaceBits>(std::move(faces)));
    }
  } catch (...) {
    makeObject();
    throw;
  }
}

void SelectionVisual::setColor(const Rgba8& color)
{
  color_ = color;
  applyMaterial();
}

void SelectionVisual::applyMaterial()
{
  auto material = makeMaterial(color_, section_);
  if (object_) {
    object_->useMaterial(material);
  }
  material_ = std::move(material);
}

FaceSelection::Faces SelectionVisual::shownOf(FaceSelection::Faces faces) const
{
  if (hidden_) {
    eraseIf(faces, [this](std::uint32_t face) { return hidden_->contains(face); });
  }
  return faces;
}

bool SelectionVisual::follow(const std::vector<ShownMesh>& shown, const FaceSelection& selection)
{
  const HiddenFacesConstPtr hidden = mesh() ? hiddenFaces(*mesh()) : nullptr;
  if (hidden != hidden_) {
    hidden_ = hidden;
    if (!selection.empty()) {
      setSelection(selection);
    }
  }
  const auto found = std::find_if(shown.begin(), shown.end(), [&](const ShownMesh& other) {
    return mesh() && other.mesh == mesh();
  });
  place(found == shown.end() ? std::nullopt : std::make_optional<FramePose>(*found));
  if (found != shown.end() && found->section != section_) {
    section_ = found->section;
    applyMaterial();
  }
  return found != shown.end();
}

bool SelectionVisual::upload(std::chrono::microseconds budget)
{
  const auto end = std::chrono::steady_clock::now() + budget;
  try {
    while (uploadSlice() && std::chrono::steady_clock::now() < end) {
    }
  } catch (...) {
    setMesh(nullptr);
    throw;
  }
  return !mesh() || (vertices_.complete() && object_->isComplete());
}

/// False where there was nothing to do.
bool SelectionVisual::uploadSlice()
{
  if (!mesh()) {
    return false;
  }
  if (const auto prepared = preparing_.take()) {
    levels_ = prepared->result.value_or(nullptr);  // else whoever needs them fails, and says so
    preparing_.drop();
  }
  if (!vertices_.complete()) {
    vertices_.upload(SLICE);
    return true;
  }
  if (object_->isWaiting()) {
    return false;
  }
  std::size_t left = SLICE;
  uploaded_bytes_ += object_->upload(left);
  return true;
}

std::size_t SelectionVisual::gpuBytes() const
{
  return vertices_.gpuBytes() + (object_ ? object_->gpuBytes() : 0);
}

}  // namespace rviz_mesh_plugin
