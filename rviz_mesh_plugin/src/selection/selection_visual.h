#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include <OgrePrerequisites.h>

#include "base/mesh_data.h"
#include "mesh_view/shown_mesh.h"
#include "rendering/labels/label_material.h"
#include "rendering/labels/label_object.h"
#include "rendering/labels/label_vertices.h"
#include "rendering/placed_visual.h"
#include "selection/face_selection.h"

namespace rviz_mesh_plugin {

/// Highlights the selected faces of a mesh, over its labels: vertices are uploaded once, and an
/// index buffer of its own of which only what changes is. GUI thread only.
class SelectionVisual : public PlacedVisual
{
 public:
  static constexpr Rgba8 COLOR{255, 140, 0, 178};

  explicit SelectionVisual(Ogre::SceneNode* parent);

  /// Replaces the mesh (null: none, and all buffers are freed); nothing is highlighted.
  void setMesh(const MeshDataConstPtr& mesh);
  const MeshDataConstPtr& mesh() const { return vertices_.mesh(); }

  /// Highlights these faces of the mesh and no others.
  void setSelection(const FaceSelection& selection);

  /// Uploads what has changed since then: faces that are highlighted must not be added, those that
  /// are not must not be removed. @throw Ogre::Exception, std::bad_alloc; nothing is highlighted
  /// then
  void apply(const FaceSelection::Change& change);

  void setColor(const Rgba8& color);

  /// To be called each frame: takes the pose that the mesh has now; hides the highlight where the
  /// mesh is not shown. @return whether it is
  bool follow(const std::vector<ShownMesh>& shown);

  /// Uploads vertices for about this long; true where nothing is left to do. Before, nothing is
  /// seen. @throw Ogre::Exception, std::bad_alloc; the mesh is given up then
  bool upload(std::chrono::microseconds budget = std::chrono::milliseconds(15));

  std::size_t gpuBytes() const;
  /// To index buffers, since the beginning.
  std::size_t uploadedBytes() const { return uploaded_bytes_; }

 private:
  void makeObject();

  LabelVertices vertices_;
  std::shared_ptr<LabelMaterial> material_;
  std::unique_ptr<LabelObject> object_;
  std::size_t uploaded_bytes_ = 0;
};

}  // namespace rviz_mesh_plugin
