#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <string>

#include <OgrePrerequisites.h>

#include "rviz_mesh_plugin/label_layers.h"
#include "rviz_mesh_plugin/label_object.h"
#include "rviz_mesh_plugin/label_order.h"
#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

/// The labels of one mesh as objects in the scene: uploaded, and laid over each other in the order
/// of their names, in slices.
class LabelObjects
{
 public:
  /// @param mesh outlives the objects; its vertices are uploaded first
  LabelObjects(Ogre::SceneNode* parent, const LabelledMesh& mesh) : parent_(parent), mesh_(mesh) {}

  /// Adds or replaces a label with faces, all of the mesh; the object is without a material at
  /// first.
  LabelObject& set(const LabelClusterConstPtr& label);
  void remove(const std::string& label);
  void clear();

  /// Null where there is none.
  LabelObject* find(const std::string& label) const;
  bool empty() const { return labels_.empty(); }

  /// Works as long as uploading @a left bytes takes, and takes that off it; returns how many bytes
  /// were uploaded. All of it is left where there is nothing to do.
  std::size_t upload(std::size_t& left);
  /// What has not been uploaded yet stays so.
  void giveUp() { waiting_.clear(); }

  std::size_t gpuBytes() const;

 private:
  struct Label
  {
    LabelClusterConstPtr cluster;
    std::unique_ptr<LabelObject> object;
  };

  void arrange(std::size_t& left);

  Ogre::SceneNode* parent_;
  const LabelledMesh& mesh_;
  std::map<std::string, Label, LabelLess> labels_;
  std::set<std::string> waiting_;  ///< labels with something to upload
  LabelLayers layers_;
  bool is_arranged_ = true;  ///< or is being arranged
};

}  // namespace rviz_mesh_plugin
