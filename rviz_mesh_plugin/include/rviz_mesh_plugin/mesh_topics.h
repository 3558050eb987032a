#pragma once

#include <memory>
#include <string>

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include "rviz_mesh_plugin/mesh_inbox.h"

namespace rviz_mesh_plugin {

/// The subscriptions of one display; messages go to its inbox.
class MeshTopics
{
 public:
  explicit MeshTopics(std::shared_ptr<MeshInbox> inbox);

  /// (Re)subscribes on the callback queue of @a node_handle; an empty @a topic only unsubscribes.
  /// After that no message of the topic before arrives any more. Returns why it is not possible,
  /// else an empty string.
  std::string subscribeGeometry(ros::NodeHandle& node_handle, const std::string& topic);
  std::string subscribeCosts(ros::NodeHandle& node_handle, const std::string& topic);
  std::string subscribeColors(ros::NodeHandle& node_handle, const std::string& topic);

  void unsubscribe();

 private:
  std::shared_ptr<MeshInbox> inbox_;
  ros::Subscriber geometry_;
  ros::Subscriber costs_;
  ros::Subscriber colors_;
};

}  // namespace rviz_mesh_plugin
