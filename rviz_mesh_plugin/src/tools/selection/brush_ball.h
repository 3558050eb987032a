#pragma once

#include <array>
#include <memory>

#include <OgrePrerequisites.h>

namespace rviz {
class Shape;
}

namespace rviz_mesh_plugin {

/// Shows where the brush is, and how large.
class BrushBall
{
 public:
  explicit BrushBall(Ogre::SceneManager* scene_manager);
  ~BrushBall();

  /// @param center in the fixed frame
  /// @param radius in meters
  /// @param adding light, else dark
  void show(const std::array<double, 3>& center, double radius, bool adding);
  void hide();
  bool isShown() const { return shape_ != nullptr; }

 private:
  Ogre::SceneManager* scene_manager_;
  std::unique_ptr<rviz::Shape> shape_;
};

}  // namespace rviz_mesh_plugin
