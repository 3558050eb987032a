#include "tools/selection/frozen_view.h"

namespace rviz_mesh_plugin {

FrozenView::FrozenView(const rviz::ViewportMouseEvent& event)
    : node_(event.viewport->getCamera()->getSceneManager()),
      camera_("frozen view", event.viewport->getCamera()->getSceneManager()),
      viewport_(&camera_, event.viewport->getTarget(), event.viewport->getLeft(),
                event.viewport->getTop(), event.viewport->getWidth(), event.viewport->getHeight(),
                0),
      event_(event)
{
  const Ogre::Camera& camera = *event.viewport->getCamera();
  node_.setPosition(camera.getDerivedPosition());
  node_.setOrientation(camera.getDerivedOrientation());
  node_.attachObject(&camera_);
  camera_.setCustomProjectionMatrix(true, camera.getProjectionMatrix());
  event_.viewport = &viewport_;
}

bool FrozenView::looksAs(const FrozenView& other) const
{
  return camera_.getDerivedPosition() == other.camera_.getDerivedPosition() &&
         camera_.getDerivedOrientation() == other.camera_.getDerivedOrientation() &&
         camera_.getProjectionMatrix() == other.camera_.getProjectionMatrix() &&
         viewport_.getActualWidth() == other.viewport_.getActualWidth() &&
         viewport_.getActualHeight() == other.viewport_.getActualHeight();
}

}  // namespace rviz_mesh_plugin
