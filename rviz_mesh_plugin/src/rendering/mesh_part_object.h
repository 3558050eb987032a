#pragma once

#include <cstddef>
#include <vector>

#include <OgreColourValue.h>
#include <OgreHardwareIndexBuffer.h>
#include <OgreMaterial.h>
#include <OgreSimpleRenderable.h>
#include <OgreVertexIndexData.h>

#include "base/section.h"
#include "level_of_detail/mesh_layout.h"
#include "rendering/ogre/finite_bounds.h"

namespace rviz_mesh_plugin {

class MeshBuffers;

/// What all parts of one mesh are drawn by; changes take effect with the next frame.
struct PartDrawing
{
  MeshBuffers* buffers = nullptr;
  /// This many indices, from the first one, can be drawn.
  std::size_t uploaded_indices = 0;
  /// Faces smaller than this many pixels may be merged; 0: never.
  float detail_pixels = 0.0f;
  const std::vector<float>* cell_sizes = nullptr;  ///< see LayoutOutline
  Section section;                                 ///< parts beside it are left out
};

/// One part of a mesh in the scene, attached to a node of its own, so that OGRE culls it. For each
/// camera it chooses its level of detail by the distance; while that is not uploaded yet, a coarser
/// one.
class MeshPartObject : public Ogre::SimpleRenderable
{
 public:
  /// @param drawing, part have to outlive the object
  MeshPartObject(const PartDrawing& drawing, const MeshPart& part);

  /// Without a material nothing is drawn. Call it again when the material has changed.
  void useMaterial(const Ogre::MaterialPtr& material);

  /// For materials that ask for the part's own color.
  void setColor(const Ogre::ColourValue& color);

  /// Draws the first so many of these indices in place of its levels; none: nothing.
  void mask(const Ogre::HardwareIndexBufferSharedPtr& indices, std::size_t count);
  /// Draws the full level alone.
  void drawInFull() { in_full_ = true; }
  /// As at first.
  void unmask();

  const MeshPart& part() const { return part_; }

  /// What was chosen for the camera that drew it last; of count 0 where nothing can be drawn.
  IndexRange drawn() const { return drawn_; }

  Ogre::Real getBoundingRadius() const override { return radiusAboutOrigin(getBoundingBox()); }
  void _notifyCurrentCamera(Ogre::Camera* camera) override;
  void _updateRenderQueue(Ogre::RenderQueue* queue) override;
  void visitRenderables(Ogre::Renderable::Visitor* visitor, bool debug_renderables) override;

  const Ogre::MaterialPtr& getMaterial() const override { return material_; }
  void getRenderOperation(Ogre::RenderOperation& operation) override;
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override;

 private:
  IndexRange choose(const Ogre::Camera& camera) const;

  const PartDrawing& drawing_;
  const MeshPart& part_;
  Ogre::IndexData index_data_;
  Ogre::MaterialPtr material_;
  bool opaque_ = true;
  IndexRange drawn_;
  bool masked_ = false;
  bool in_full_ = false;
  Ogre::HardwareIndexBufferSharedPtr mask_;
  std::size_t mask_count_ = 0;
};

}  // namespace rviz_mesh_plugin
