#pragma once

#include <string>

#include <OgreCamera.h>
#include <OgreSceneNode.h>
#include <OgreViewport.h>
#include <rviz/viewport_mouse_event.h>

namespace rviz_mesh_plugin {

/// An event of the mouse with the picture in which it came: what is done with it later is as the
/// camera looked then. GUI thread only.
class FrozenView
{
 public:
  /// @param event in a viewport with a camera, not empty
  explicit FrozenView(const rviz::ViewportMouseEvent& event);
  FrozenView(const FrozenView&) = delete;
  FrozenView& operator=(const FrozenView&) = delete;

  const rviz::ViewportMouseEvent& event() const { return event_; }
  const Ogre::Viewport& viewport() const { return viewport_; }

  /// The camera has not moved in between, nor the picture changed its size.
  bool looksAs(const FrozenView& other) const;

 private:
  Ogre::SceneNode node_;  ///< of the camera, in no scene
  Ogre::Camera camera_;
  Ogre::Viewport viewport_;
  rviz::ViewportMouseEvent event_;
};

}  // namespace rviz_mesh_plugin
