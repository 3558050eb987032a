#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <OgrePrerequisites.h>

#include "base/mesh_data.h"
#include "labels/label_colors.h"
#include "rendering/labels/label_overlay.h"

namespace rviz_mesh_plugin {

/// The labels of one mesh, drawn over it. GUI thread only.
class MeshLabels
{
 public:
  explicit MeshLabels(Ogre::SceneNode* parent) : parent_(parent) {}

  /// Draws these labels and no others; only those that are new or have changed
  /// are uploaded.
  /// @throw Ogre::Exception, std::bad_alloc
  void show(const MeshDataConstPtr& mesh, const LabelClusters& labels, float alpha,
            const Section& section);
  void clear();

  /// Labels have these colors from now on; returns whether one that is drawn has another one than
  /// before. @throw Ogre::Exception, std::bad_alloc
  bool setOwnColors(const OwnColorsConstPtr& own);

  /// True where nothing is left to upload.
  bool upload(std::chrono::microseconds budget);
  void setPose(const std::optional<FramePose>& pose);

  std::size_t count() const { return drawn_.size(); }
  /// Faces of labels that the mesh does not have.
  std::size_t leftOut() const;

 private:
  Ogre::SceneNode* parent_;
  std::unique_ptr<LabelOverlay> overlay_;  ///< only while there are labels
  MeshDataConstPtr mesh_;
  struct Drawn
  {
    LabelClusterConstPtr label;
    std::size_t left_out = 0;  ///< faces
  };
  std::map<std::string, Drawn> drawn_;  ///< by label
  LabelColors colors_;
  std::optional<FramePose> pose_;
};

}  // namespace rviz_mesh_plugin
