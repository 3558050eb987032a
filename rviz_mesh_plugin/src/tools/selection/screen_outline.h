#pragma once

#include <vector>

#include <OgreAxisAlignedBox.h>
#include <OgreHardwareVertexBuffer.h>
#include <OgreMaterial.h>
#include <OgreMovableObject.h>
#include <OgreRenderable.h>
#include <OgreVertexIndexData.h>

#include "selection/selection_gestures.h"
#include "selection/selection_regions.h"

namespace rviz_mesh_plugin {

/// What is being dragged, drawn over the picture of one viewport: a light line with a dark border,
/// two and four pixels wide.
class ScreenOutline : public Ogre::MovableObject, public Ogre::Renderable
{
 public:
  explicit ScreenOutline(Ogre::SceneManager* scene_manager);
  ~ScreenOutline() override;
  ScreenOutline(const ScreenOutline&) = delete;
  ScreenOutline& operator=(const ScreenOutline&) = delete;

  /// @param corners of a polygon that is closed; a single one is not seen
  void show(const Ogre::Viewport& viewport, const std::vector<Pixel>& corners);
  /// A rectangle, slightly filled.
  void showBox(const Ogre::Viewport& viewport, const Pixel& corner, const Pixel& opposite);
  void hide() { viewport_ = nullptr; }

  /// MovableObject and Renderable.
  const Ogre::String& getMovableType() const override;
  const Ogre::AxisAlignedBox& getBoundingBox() const override { return bounds_; }
  Ogre::Real getBoundingRadius() const override { return 0.0f; }
  bool isVisible() const override;
  void _notifyCurrentCamera(Ogre::Camera* camera) override;
  void _updateRenderQueue(Ogre::RenderQueue* queue) override;
  void visitRenderables(Ogre::Renderable::Visitor* visitor, bool debug_renderables) override;
  const Ogre::MaterialPtr& getMaterial() const override { return material_; }
  void getRenderOperation(Ogre::RenderOperation& operation) override;
  void getWorldTransforms(Ogre::Matrix4* transform) const override;
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override;
  const Ogre::LightList& getLights() const override { return queryLights(); }

 private:
  struct Vertex
  {
    float x, y, z;
    Rgba8 color;
  };

  void addLine(const Ogre::Viewport& viewport, const Pixel& from, const Pixel& to, double width,
               const Rgba8& color);
  void addLines(const Ogre::Viewport& viewport, const std::vector<Pixel>& corners);
  void upload(const Ogre::Viewport& viewport);

  Ogre::SceneNode* node_;
  Ogre::MaterialPtr material_;
  Ogre::AxisAlignedBox bounds_;
  Ogre::VertexData data_;
  Ogre::HardwareVertexBufferSharedPtr buffer_;
  std::vector<Vertex> vertices_;              ///< of triangles, in normalized device coordinates
  const Ogre::Viewport* viewport_ = nullptr;  ///< only compared; null: hidden
  const Ogre::Viewport* drawn_in_ = nullptr;
};

}  // namespace rviz_mesh_plugin
