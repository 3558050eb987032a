#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <OgrePrerequisites.h>

#include "base/hidden_faces.h"
#include "base/mesh_data.h"
#include "base/section.h"
#include "labels/label_colors.h"
#include "rendering/placed_visual.h"
#include "rendering/text/scene_text.h"
#include "threads/background_task.h"

namespace Ogre {
class Camera;
}

namespace rviz_mesh_plugin {

/// A point of a label on the surface: the middle of that of its faces that is nearest to the mean
/// of all their middles. In the coordinates of the mesh.
/// @param faces of the label, all of the mesh; none: not a number
/// @throw Canceled (cancellation.h)
std::array<double, 3> placeOfName(const MeshData& mesh, const std::vector<std::uint32_t>& faces,
                                  const std::atomic<bool>* cancel = nullptr);

/// The names of labels, each over a point of its label, in the pose of the mesh: over everything
/// that is before them, and none over another one. GUI thread only; points are looked for on a
/// thread.
class LabelNames : public PlacedVisual
{
 public:
  /// Of more labels, the names of those with the most faces are drawn.
  static constexpr std::size_t MOST = 50;

  explicit LabelNames(Ogre::SceneNode* parent) : PlacedVisual(parent) {}

  /// These labels from now on; of a mesh (null: none).
  /// @param hidden faces, over which there is no name; null: none
  void setLabels(const MeshDataConstPtr& mesh, const LabelClusters& labels, const LabelLooks& looks,
                 const HiddenFacesConstPtr& hidden);

  /// To be called each frame: places the names in the picture of the camera, and leaves out those
  /// of points outside of the section. @throw Ogre::Exception, std::bad_alloc, std::system_error
  /// @return whether something is to be drawn anew
  bool update(const Ogre::Camera* camera, const Section& section);

  /// Those that are in the picture, as update() left them.
  std::vector<std::string> drawn() const;
  /// Labels without a name because of MOST.
  std::size_t leftOut() const { return left_out_; }

 private:
  using Places = std::map<LabelClusterConstPtr, std::array<double, 3>>;
  struct Name
  {
    LabelClusterConstPtr label;
    Rgba8 color;
    std::unique_ptr<SceneText> text;  ///< null before its place is known
    bool drawn = false;
  };

  void findPlaces();

  MeshDataConstPtr mesh_;
  HiddenFacesConstPtr hidden_;
  std::vector<Name> names_;  ///< those with the most faces first
  std::size_t left_out_ = 0;
  Places places_;
  BackgroundTask<Places> task_{"label names"};
  bool failed_ = false;  ///< it has, and is not begun again before there are other labels
};

}  // namespace rviz_mesh_plugin
