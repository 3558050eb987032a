#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <OgreHardwareIndexBuffer.h>
#include <OgreSimpleRenderable.h>
#include <OgreVertexIndexData.h>

#include "base/hidden_faces.h"
#include "rendering/labels/index_slots.h"
#include "rendering/labels/label_material.h"
#include "rendering/labels/label_parts.h"
#include "rendering/labels/label_vertices.h"

namespace rviz_mesh_plugin {

struct PixelSize;

/// Draws some faces of a mesh in one color, with an index buffer and bounds of its own, below a
/// scene node of its own, so that OGRE leaves it out where it is out of sight. More than
/// MANY_FACES, and where that is asked for, are drawn part by part, those in sight, in the levels
/// of detail that the mesh has there (LabelParts); a label that has been so stays so.
///
/// Faces that are new appear once all of them have been uploaded (of many that change later: part
/// by part). Of faces that are set faster than that, the last ones follow.
class LabelObject : public Ogre::SimpleRenderable
{
 public:
  /// @param vertices outlive the object
  /// @param growing leaves room in the buffer for more faces
  LabelObject(Ogre::SceneNode* parent, LabelVertices& vertices, bool growing = true);
  ~LabelObject() override;

  /// @param faces ascending, each once, all of the mesh
  /// @param hidden those that are left out; null: none
  void setFaces(std::shared_ptr<const IndexSlots::Faces> faces, bool in_parts = false,
                const HiddenFacesConstPtr& hidden = nullptr);
  /// Part by part, and often.
  void setFaces(std::shared_ptr<const FaceBits> faces);
  bool inParts() const { return parts_ != nullptr; }
  /// Adds faces to those that are drawn, takes others away, and uploads that: what is changed like
  /// this is never set as a whole. Returns how many bytes were uploaded.
  std::size_t changeFaces(const IndexSlots::Faces& added, const IndexSlots::Faces& removed);
  void useMaterial(const std::shared_ptr<LabelMaterial>& material) { material_ = material; }
  void setShown(bool shown) { shown_ = shown; }
  /// Of labels that lie on the same faces, the one with the higher layer is seen.
  void setLayer(unsigned short layer) { layer_ = layer; }

  bool isComplete() const
  {
    return parts_ ? parts_->isComplete() : !wanted_ && slots_.isSettled() && dirty_.empty();
  }
  /// upload() can do nothing at the moment.
  bool isWaiting() const { return parts_ ? parts_->isWaiting() : isComplete(); }
  /// Prepares and uploads what takes about as long as uploading @a left bytes (but one face at
  /// least), and takes that off it; returns how many bytes were uploaded.
  std::size_t upload(std::size_t& left);
  std::size_t gpuBytes() const;
  /// Faces that were drawn for the camera that drew it last, in view.
  std::size_t facesDrawn() const;

  Ogre::Real getBoundingRadius() const override;
  bool isVisible() const override;
  void _notifyCurrentCamera(Ogre::Camera* camera) override;
  void _updateRenderQueue(Ogre::RenderQueue* queue) override;
  void visitRenderables(Ogre::Renderable::Visitor* visitor, bool debug_renderables) override;
  const Ogre::MaterialPtr& getMaterial() const override { return material_->get(); }
  void getRenderOperation(Ogre::RenderOperation& operation) override;
  void getWorldTransforms(Ogre::Matrix4* transform) const override;
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override;

 protected:
  void addTo(Ogre::RenderQueue* queue, Ogre::uint8 group, Ogre::ushort priority);

 private:
  class PartRenderable;

  bool drawsParts() const { return parts_ && parts_->isDrawable(); }
  void chooseParts(const Ogre::Camera& camera, const PixelSize& pixel);
  void transform(Ogre::Matrix4* transform, float nearer) const;
  void prepare(std::size_t& left);
  void takeChanges();
  void drawAll();
  /// The bounding box encloses all faces written so far.
  void write(std::size_t begin, std::size_t end);

  Ogre::SceneNode* node_;
  LabelVertices& vertices_;
  std::shared_ptr<LabelMaterial> material_;
  const bool growing_;
  std::shared_ptr<const IndexSlots::Faces> wanted_;  ///< newer than those of the slots
  IndexSlots slots_;
  std::vector<IndexSlots::Range> dirty_;
  Ogre::HardwareIndexBufferSharedPtr buffer_;  ///< uploaded to
  /// What is drawn: of another buffer until that one is complete.
  Ogre::IndexData drawn_;
  std::unique_ptr<LabelParts> parts_;  ///< null: they are not many
  std::vector<std::unique_ptr<PartRenderable>> drawn_parts_;
  bool shown_ = true;
  unsigned short layer_ = 0;
  /// The faces are drawn nearer to the camera by this share of their distance (or, in a parallel
  /// projection, by so many meters towards the camera).
  float nearer_ = 0.0f;
  bool parallel_ = false;
  Ogre::Vector3 eye_ = Ogre::Vector3::ZERO;
  Ogre::Vector3 towards_camera_ = Ogre::Vector3::ZERO;
};

}  // namespace rviz_mesh_plugin
