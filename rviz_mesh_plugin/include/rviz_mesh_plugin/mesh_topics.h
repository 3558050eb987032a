#pragma once

#include <memory>
#include <string>

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include "rviz_mesh_plugin/mesh_inbox.h"

namespace rviz_mesh_plugin {

class MeshLoader;

/// The subscriptions of one display; messages go to its inbox, meshes to its loader.
class MeshTopics
{
 public:
  MeshTopics(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader);

  /// (Re)subscribes on the callback queue of @a node_handle; an empty @a topic only unsubscribes.
  /// After that no message of the topic before arrives any more. Returns why it is not possible,
  /// else an empty string.
  std::string subscribeGeometry(ros::NodeHandle& node_handle, const std::string& topic);
  std::string subscribeCosts(ros::NodeHandle& node_handle, const std::string& topic);
  std::string subscribeFaceCosts(ros::NodeHandle& node_handle, const std::string& topic);
  std::string subscribeUpdates(ros::NodeHandle& node_handle, const std::string& topic);
  std::string subscribeColors(ros::NodeHandle& node_handle, const std::string& topic);
  std::string subscribeMaterials(ros::NodeHandle& node_handle, const std::string& topic);
  std::string subscribeTextures(ros::NodeHandle& node_handle, const std::string& topic);
  /// mesh_msgs/MeshFaceCluster: each message is one label as it is now.
  std::string subscribeLabels(ros::NodeHandle& node_handle, const std::string& topic);

  void unsubscribe();

 private:
  std::shared_ptr<MeshInbox> inbox_;
  std::shared_ptr<MeshLoader> loader_;
  ros::Subscriber geometry_;
  ros::Subscriber costs_;
  ros::Subscriber face_costs_;
  ros::Subscriber updates_;
  ros::Subscriber colors_;
  ros::Subscriber materials_;
  ros::Subscriber textures_;
  ros::Subscriber labels_;
};

}  // namespace rviz_mesh_plugin
