#pragma once

#include <OgreMaterial.h>
#include <OgreTexture.h>
#include <QImage>

namespace Ogre {
class Overlay;
class OverlayContainer;
}  // namespace Ogre

namespace rviz_mesh_plugin {

/// A picture over the 3D view, at its right side. RViz shows overlays in its main view alone: the
/// views of cameras leave them out. GUI thread only.
class LegendOverlay
{
 public:
  /// @throw std::runtime_error where OGRE has no overlays
  LegendOverlay();
  ~LegendOverlay();
  LegendOverlay(const LegendOverlay&) = delete;
  LegendOverlay& operator=(const LegendOverlay&) = delete;

  /// @param picture format ARGB32
  void setPicture(const QImage& picture);

  /// In pixels: from the right side of the view to the right side of the picture, and from the top.
  void setPosition(int right, int top);
  void setVisible(bool visible);

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  void destroy();

  Ogre::TexturePtr texture_;
  Ogre::MaterialPtr material_;
  Ogre::OverlayContainer* element_ = nullptr;
  Ogre::Overlay* overlay_ = nullptr;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace rviz_mesh_plugin
