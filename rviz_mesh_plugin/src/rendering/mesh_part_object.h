#pragma once

#include <cstddef>
#include <vector>

#include <OgreAxisAlignedBox.h>
#include <OgreColourValue.h>
#include <OgreMaterial.h>
#include <OgreMovableObject.h>
#include <OgreRenderable.h>
#include <OgreVertexIndexData.h>

#include "level_of_detail/mesh_layout.h"

namespace rviz_mesh_plugin {

class MeshBuffers;

/// What all parts of one mesh are drawn by; changes take effect with the next frame.
struct PartDrawing
{
  Ogre::VertexData* vertices = nullptr;
  const MeshBuffers* buffers = nullptr;  ///< of the indices
  /// This many indices, from the first one, can be drawn.
  std::size_t uploaded_indices = 0;
  /// Faces smaller than this many pixels may be merged; 0: never.
  float detail_pixels = 0.0f;
  const std::vector<float>* cell_sizes = nullptr;  ///< see LayoutOutline
};

/// One part of a mesh in the scene, attached to a node of its own, so that OGRE culls it. For each
/// camera it chooses its level of detail by the distance; while that is not uploaded yet, a coarser
/// one.
class MeshPartObject : public Ogre::MovableObject, public Ogre::Renderable
{
 public:
  /// Of the custom parameter of this renderable that holds color().
  static constexpr std::size_t COLOR_PARAMETER = 17;

  /// @param drawing, part have to outlive the object
  MeshPartObject(const PartDrawing& drawing, const MeshPart& part);

  /// Without a material nothing is drawn. Call it again when the material has changed.
  void setMaterial(const Ogre::MaterialPtr& material);

  /// For materials that ask for the part's own color.
  void setColor(const Ogre::ColourValue& color);

  const MeshPart& part() const { return part_; }

  /// What was chosen for the camera that drew it last; of count 0 where nothing can be drawn.
  IndexRange drawn() const { return drawn_; }

  const Ogre::String& getMovableType() const override;
  const Ogre::AxisAlignedBox& getBoundingBox() const override { return box_; }
  Ogre::Real getBoundingRadius() const override { return radius_; }
  void _notifyCurrentCamera(Ogre::Camera* camera) override;
  void _updateRenderQueue(Ogre::RenderQueue* queue) override;
  void visitRenderables(Ogre::Renderable::Visitor* visitor, bool debug_renderables) override;

  const Ogre::MaterialPtr& getMaterial() const override { return material_; }
  void getRenderOperation(Ogre::RenderOperation& operation) override;
  void getWorldTransforms(Ogre::Matrix4* transform) const override;
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override;
  const Ogre::LightList& getLights() const override;

 private:
  IndexRange choose(const Ogre::Camera& camera) const;

  const PartDrawing& drawing_;
  const MeshPart& part_;
  Ogre::AxisAlignedBox box_;
  Ogre::Real radius_ = 0;
  Ogre::IndexData index_data_;
  Ogre::MaterialPtr material_;
  bool opaque_ = true;
  IndexRange drawn_;
};

}  // namespace rviz_mesh_plugin
