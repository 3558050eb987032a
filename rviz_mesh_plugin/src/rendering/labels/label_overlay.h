#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <string>

#include <OgrePrerequisites.h>

#include "base/hidden_faces.h"
#include "base/mesh_data.h"
#include "labels/label_colors.h"
#include "labels/label_name.h"
#include "rendering/labels/label_layers.h"
#include "rendering/labels/label_material.h"
#include "rendering/labels/label_object.h"
#include "rendering/labels/label_vertices.h"
#include "rendering/placed_visual.h"

namespace rviz_mesh_plugin {

/// Draws labelled faces of a mesh over (and, where the mesh is not drawn, instead of) it, in the
/// pose of the mesh. GUI thread only.
///
/// One vertex buffer, made with the first label, and an index buffer per label of which only what
/// changed is uploaded, in slices by upload(). Labels that have more than MANY_FACES together are
/// drawn in levels of detail, but for small ones. Opaque labels that lie on the same faces are
/// drawn in the order of their names (LabelLess), so that the last one is seen (of more than 16 on
/// one face: one of the last); translucent ones blend.
class LabelOverlay : public PlacedVisual
{
 public:
  explicit LabelOverlay(Ogre::SceneNode* parent) : PlacedVisual(parent) {}

  /// Replaces the mesh (null: none); labels are gone, their colors and visibility are kept.
  void setMesh(const MeshDataConstPtr& mesh);

  /// Adds or replaces one label; without faces it is removed. Faces beyond the mesh are left out;
  /// returns how many.
  std::size_t setLabel(const LabelClusterConstPtr& cluster);
  void removeLabel(const std::string& label);

  /// Also of labels that are gone.
  const LabelLooks& looks() const { return looks_; }
  void setColor(const std::string& label, const Rgba8& color);
  using PlacedVisual::setVisible;
  void setVisible(const std::string& label, bool visible);
  void setAlpha(float alpha) { materials_.setAlpha(alpha); }
  /// What is drawn of them, and of the phantom, in the coordinates of the mesh.
  void setSection(const Section& section);
  /// These faces of the mesh (null: none) are not drawn; of another mesh none is hidden at first.
  void setHidden(const HiddenFacesConstPtr& hidden);
  /// Draws the whole mesh, rgb .2/.3/.2, alpha .1.
  void setPhantom(bool shown);

  /// Uploads for about this long, at least one slice; true where nothing is left to do. Labels show
  /// once they are complete. @throw Ogre::Exception, std::bad_alloc: what cannot be uploaded is
  /// given up
  bool upload(std::chrono::microseconds budget = std::chrono::milliseconds(15));

  /// Of vertices and labels.
  std::size_t gpuBytes() const;
  /// Faces that were drawn for the camera that drew them last, in view; of the labels.
  std::size_t facesDrawn() const;
  /// Since the beginning.
  std::size_t uploadedBytes() const { return uploaded_bytes_; }

 private:
  struct Label
  {
    LabelClusterConstPtr cluster;
    std::unique_ptr<LabelObject> object;
  };

  LabelObject* find(const std::string& label) const;
  void applyLook(const std::string& label);
  void setFaces(Label& label);
  void setPhantomFaces();
  bool uploadSlice();
  std::size_t uploadLabels(std::size_t& left);
  void arrange(std::size_t& left);

  LabelMaterials materials_;
  LabelVertices vertices_;
  std::map<std::string, Label, LabelLess> labels_;
  std::size_t face_count_ = 0;     ///< of all labels
  std::set<std::string> waiting_;  ///< labels with something to upload
  LabelLayers layers_;
  bool is_arranged_ = true;  ///< or is being arranged
  LabelLooks looks_;
  HiddenFacesConstPtr hidden_;
  std::unique_ptr<LabelObject> phantom_;
  std::shared_ptr<LabelMaterial> phantom_material_;
  bool phantom_shown_ = false;
  std::size_t uploaded_bytes_ = 0;
};

}  // namespace rviz_mesh_plugin
