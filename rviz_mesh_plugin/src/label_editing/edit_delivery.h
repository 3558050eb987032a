#pragma once

#include <map>
#include <string>
#include <utility>

#include <ros/node_handle.h>

#include "displays/cluster_label_display.h"
#include "label_editing/pending_edits.h"
#include "sources/edit_publisher.h"

namespace rviz_mesh_plugin {

/// Takes edits to who stores labels, and tells whether they have come back as stored. All through
/// a display of their mesh. GUI thread only.
class EditDelivery
{
 public:
  EditDelivery();

  /// Returns why it cannot be sent, else an empty string.
  std::string send(const LabelEdit& edit, ClusterLabelDisplay& display);
  bool isStored(const LabelEdit& edit, const ClusterLabelDisplay& display);

  /// What was known of the label of this edit, which is another one than before, does not count.
  void forget(const LabelEdit& edit) { other_.erase({edit.mesh, edit.label}); }
  void forgetAll() { other_.clear(); }

 private:
  ros::NodeHandle node_;
  EditPublisher everybody_;
  /// Labels that are not what an edit wants: they are not compared again.
  std::map<std::pair<MeshId, std::string>, LabelClusterConstPtr> other_;
};

}  // namespace rviz_mesh_plugin
