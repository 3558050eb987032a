#pragma once

#include <memory>
#include <string>

#include <ros/node_handle.h>

#include "base/status_lines.h"
#include "ros_client/topic_receiver.h"

namespace rviz_mesh_plugin {

/// What the node that publishes a mesh says of it, on the topic "remark" beside that of the
/// geometry: mesh_map does so where edges are too long for robot and layers. GUI thread only.
class MapRemarkSource
{
 public:
  MapRemarkSource();

  /// Follows what is said beside this topic; nothing happens where it does so already, and where
  /// it is empty, nothing is followed. A name that is none is said where the geometry is
  /// subscribed to.
  void connect(ros::NodeHandle& node_handle, const std::string& geometry_topic);
  void disconnect();

  /// The newest; nothing where that is empty, or none has come.
  OptionalStatus status() const;

 private:
  struct Newest;

  std::string topic_;  ///< empty: not connected
  TopicReceiver receiver_;
  TopicReceiver::Subscription subscription_;
  std::shared_ptr<Newest> newest_;
};

}  // namespace rviz_mesh_plugin
