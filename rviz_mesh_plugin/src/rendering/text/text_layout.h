#pragma once

#include <optional>
#include <vector>

#include "rendering/ogre/ogre_compatibility.h"

namespace Ogre {
class Camera;
}

namespace rviz_mesh_plugin {

/// Where a point is in a picture, in pixels from its left lower corner; none where it is behind the
/// camera, or there is no picture.
struct PicturePlace
{
  float x = 0.0f;
  float y = 0.0f;
  float meters = 0.0f;  ///< of a pixel there
};
std::optional<PicturePlace> placeInPicture(const Ogre::Vector3& point, const Ogre::Camera* camera);

/// Gives texts places in the picture where none covers another. The first ones go first.
class TextLayout
{
 public:
  /// @param camera null: everything is free
  explicit TextLayout(const Ogre::Camera* camera) : camera_(camera) {}

  /// Tries places about a point: above it, below, to the right, to the left.
  /// @param width, height in pixels
  /// @return how far from above the point, in pixels to the right and upwards; none where nothing
  /// is free, or the point is behind the camera
  std::optional<std::pair<int, int>> add(const Ogre::Vector3& point, int width, int height);

 private:
  struct Box
  {
    float left, low, right, high;
  };
  bool isFree(const Box& box) const;

  const Ogre::Camera* camera_;
  std::vector<Box> taken_;
};

}  // namespace rviz_mesh_plugin
