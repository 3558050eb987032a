#include "rendering/placed_visual.h"

#include <cmath>

namespace rviz_mesh_plugin {

PlacedVisual::PlacedVisual(Ogre::SceneNode* parent)
    : parent_(parent), node_(parent->createChildSceneNode())
{
}

PlacedVisual::~PlacedVisual()
{
  destroySceneNode(node_);
}

/// Takes it out of the scene: RViz makes all attached objects visible when the display is enabled.
void PlacedVisual::setVisible(bool visible)
{
  if (visible == (node_->getParent() != nullptr)) {
    return;
  }
  if (visible) {
    parent_->addChild(node_);
  } else {
    parent_->removeChild(node_);
  }
}

void PlacedVisual::place(const std::optional<FramePose>& pose)
{
  setVisible(pose.has_value());
  if (pose && !pose->position.isNaN() && !pose->orientation.isNaN() &&
      std::isfinite(pose->position.squaredLength())) {
    node_->setPosition(pose->position);
    node_->setOrientation(pose->orientation);
  }
}

}  // namespace rviz_mesh_plugin
