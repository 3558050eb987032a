#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "measurement/measurement.h"
#include "mesh_view/shown_mesh.h"
#include "rendering/text/scene_text.h"
#include "tools/measuring/surface_marks.h"

namespace Ogre {
class Camera;
}

namespace rviz_mesh_plugin {

/// What is drawn of measurements: their points and lines, through what is before them, and their
/// values beside. GUI thread only.
class MeasurementMarks
{
 public:
  /// @param scene_manager outlives this
  explicit MeasurementMarks(Ogre::SceneManager* scene_manager);
  ~MeasurementMarks();

  /// Draws those that are not stale and whose mesh is shown, and no others.
  /// @param size of points in meters, where that is more than a few pixels for the camera (may be
  /// null)
  void show(const std::vector<Measurement>& measurements, const std::vector<ShownMesh>& shown,
            const Ogre::Camera* camera, float size, bool values);

  /// Points of a measurement that is not complete, joined by lines, as they follow each other.
  /// @param next where the cursor is; none: null
  void showPoints(const ShownMesh& mesh, const std::vector<SurfacePoint>& points,
                  const std::array<double, 3>* next);
  void clearPoints();

 private:
  struct Mark
  {
    Measurement::State state;
    ShownMesh mesh;
    std::array<double, 3> anchor{};                ///< of the text, in the coordinates of the mesh
    Ogre::Vector3 position = Ogre::Vector3::ZERO;  ///< of that in the scene
    std::unique_ptr<SurfaceMarks> marks;
    std::unique_ptr<SceneText> text;
    float size = 0.0f;
  };
  std::unique_ptr<Mark> make(const Measurement& measurement, const ShownMesh& mesh);
  static void place(Mark& mark, const std::vector<ShownMesh>& shown, const Ogre::Camera* camera,
                    float size);

  Ogre::SceneManager* scene_manager_;
  std::map<std::uint32_t, std::unique_ptr<Mark>> marks_;  ///< by number
  std::unique_ptr<Mark> begun_;
};

}  // namespace rviz_mesh_plugin
