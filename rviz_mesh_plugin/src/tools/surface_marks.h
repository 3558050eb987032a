#pragma once

#include <array>
#include <memory>
#include <vector>

#include <OgrePrerequisites.h>

#include "mesh_view/shown_mesh.h"

namespace rviz {
class BillboardLine;
class Shape;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// Balls at points of meshes, and a line along a surface, which move with the meshes. The line is
/// seen through what is before it. GUI thread only.
class SurfaceMarks
{
 public:
  /// @param scene_manager outlives this
  explicit SurfaceMarks(Ogre::SceneManager* scene_manager);
  ~SurfaceMarks();
  SurfaceMarks(const SurfaceMarks&) = delete;
  SurfaceMarks& operator=(const SurfaceMarks&) = delete;

  /// @param point in the coordinates of the mesh, as all points
  void addBall(const ShownMesh& mesh, const std::array<double, 3>& point);
  /// @param points 3 coordinates each
  void setLine(const ShownMesh& mesh, const std::vector<double>& points);
  void clear();

  /// The diameter of the balls in meters.
  void setSize(float size);

  /// To be called each frame: takes the poses that the meshes have now, and hides what is on those
  /// that are not shown.
  void follow(const std::vector<ShownMesh>& shown);

 private:
  struct Ball
  {
    ShownMesh mesh;
    std::array<double, 3> point{};
    std::unique_ptr<rviz::Shape> shape;
  };

  Ogre::SceneManager* scene_manager_;
  float size_ = 0.1f;
  std::vector<Ball> balls_;
  ShownMesh line_mesh_;
  std::vector<double> line_points_;
  std::unique_ptr<rviz::BillboardLine> line_;
};

}  // namespace rviz_mesh_plugin
