#pragma once

#include <array>
#include <memory>
#include <vector>

#include <OgreColourValue.h>
#include <OgrePrerequisites.h>

#include "mesh_view/shown_mesh.h"

namespace rviz {
class BillboardLine;
class Shape;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// Balls at points of meshes, and lines along their surfaces, which move with the meshes. Lines are
/// seen through what is before them. GUI thread only.
class SurfaceMarks
{
 public:
  static const Ogre::ColourValue LINE_COLOR;

  /// @param scene_manager outlives this
  explicit SurfaceMarks(Ogre::SceneManager* scene_manager);
  ~SurfaceMarks();
  SurfaceMarks(const SurfaceMarks&) = delete;
  SurfaceMarks& operator=(const SurfaceMarks&) = delete;

  /// @param point in the coordinates of the mesh, as all points
  void addBall(const ShownMesh& mesh, const std::array<double, 3>& point);
  /// @param points 3 coordinates each
  void addLine(const ShownMesh& mesh, const std::vector<double>& points,
               const Ogre::ColourValue& color = LINE_COLOR);
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

  struct Line
  {
    ShownMesh mesh;
    std::array<double, 3> origin{};
    std::unique_ptr<rviz::BillboardLine> line;
  };

  static void place(const Line& line, const ShownMesh& mesh);

  Ogre::SceneManager* scene_manager_;
  float size_ = 0.1f;
  std::vector<Ball> balls_;
  std::vector<Line> lines_;
};

}  // namespace rviz_mesh_plugin
