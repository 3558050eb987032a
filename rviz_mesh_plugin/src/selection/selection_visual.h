#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include <OgrePrerequisites.h>

#include "base/mesh_data.h"
#include "level_of_detail/overlay_levels.h"
#include "mesh_view/shown_mesh.h"
#include "rendering/labels/label_material.h"
#include "rendering/labels/label_object.h"
#include "rendering/labels/label_vertices.h"
#include "rendering/placed_visual.h"
#include "selection/face_selection.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// Highlights the selected faces of a mesh, over its labels: vertices are uploaded once, and an
/// index buffer of its own of which only what changes is. Changes of few faces are uploaded at
/// once; many faces are made on a thread and uploaded in slices, and drawn in levels of detail (see
/// LabelObject). GUI thread only.
class SelectionVisual : public PlacedVisual
{
 public:
  static constexpr Rgba8 COLOR{255, 140, 0, 178};

  explicit SelectionVisual(Ogre::SceneNode* parent);

  /// Replaces the mesh (null: none, and all buffers are freed); nothing is highlighted.
  void setMesh(const MeshDataConstPtr& mesh);
  const MeshDataConstPtr& mesh() const { return vertices_.mesh(); }

  /// Highlights these faces of the mesh and no others, but for hidden ones.
  void setSelection(const FaceSelection& selection);

  /// Follows a change of the selection that is highlighted.
  /// @param selection after it
  /// @throw Ogre::Exception, std::bad_alloc; nothing is highlighted then
  void apply(const FaceSelection& selection, const FaceSelection::Change& change);

  /// What is drawn is the selection, or will be once its vertices are uploaded; else upload() has
  /// something to do, or waits for a thread.
  bool isCurrent() const { return !object_ || object_->isComplete(); }

  void setColor(const Rgba8& color);

  /// To be called each frame: takes the pose that the mesh has now; hides the highlight where the
  /// mesh is not shown, and where that is cut or hidden. @return whether it is shown
  bool follow(const std::vector<ShownMesh>& shown, const FaceSelection& selection);

  /// Uploads for about this long; true where nothing is left to do. Before the vertices are,
  /// nothing is seen. @throw Ogre::Exception, std::exception; the mesh is given up then
  bool upload(std::chrono::microseconds budget = std::chrono::milliseconds(15));

  std::size_t gpuBytes() const;
  /// To index buffers, since the beginning.
  std::size_t uploadedBytes() const { return uploaded_bytes_; }
  /// For the camera that drew it last, in view.
  std::size_t facesDrawn() const { return object_ ? object_->facesDrawn() : 0; }

 private:
  void makeObject();
  bool uploadSlice();
  /// Without the hidden ones.
  FaceSelection::Faces shownOf(FaceSelection::Faces faces) const;

  LabelVertices vertices_;
  OverlayLevelsConstPtr levels_;  ///< kept for when many faces are selected, and again
  BackgroundTask<OverlayLevelsConstPtr> preparing_{"overlay levels"};
  void applyMaterial();

  Rgba8 color_ = COLOR;
  Section section_;
  HiddenFacesConstPtr hidden_;  ///< of the mesh
  std::shared_ptr<LabelMaterial> material_;
  std::unique_ptr<LabelObject> object_;
  std::size_t uploaded_bytes_ = 0;
};

}  // namespace rviz_mesh_plugin
