#pragma once

#include <optional>

#include <OgreQuaternion.h>

#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {

/// Where something is drawn: its pose in the fixed frame.
struct FramePose
{
  Ogre::Vector3 position = Ogre::Vector3::ZERO;
  Ogre::Quaternion orientation = Ogre::Quaternion::IDENTITY;
};

/// What is drawn below a scene node of its own, which is destroyed with it. GUI thread only.
class PlacedVisual
{
 public:
  PlacedVisual(const PlacedVisual&) = delete;
  PlacedVisual& operator=(const PlacedVisual&) = delete;

  void setVisible(bool visible);
  /// Shows it in a pose (in that of before, where this one is not finite); hides it where there is
  /// none.
  void place(const std::optional<FramePose>& pose);

 protected:
  explicit PlacedVisual(Ogre::SceneNode* parent);
  ~PlacedVisual();

  Ogre::SceneNode* node() const { return node_; }

 private:
  Ogre::SceneNode* const parent_;
  Ogre::SceneNode* const node_;
};

}  // namespace rviz_mesh_plugin
