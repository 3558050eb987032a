#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <ros/node_handle.h>

#include "incoming/mesh_inbox.h"
#include "ros_client/topic_receiver.h"

namespace rviz_mesh_plugin {

class MeshLoader;

/// The subscriptions of one display; messages go to its inbox, meshes to its loader. Nothing waits
/// for a message that is being read.
class MeshTopics
{
 public:
  MeshTopics(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader);

  /// (Re)subscribes; an empty @a topic only unsubscribes. What is forgotten in the inbox (or the
  /// loader) after that comes back from no message of the topic before. Returns why it is not
  /// possible, else an empty string.
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
  using Subscription = TopicReceiver::Subscription;

  template <class Message>
  std::string subscribe(Subscription& subscription, ros::NodeHandle& node_handle,
                        const std::string& topic, std::uint32_t queue,
                        const TopicReceiver::Callbacks<Message>& callbacks);
  template <class Message>
  std::string subscribe(Subscription& subscription, ros::NodeHandle& node_handle,
                        const std::string& topic, std::uint32_t queue,
                        Reception InboxContent::*reception);

  std::shared_ptr<MeshInbox> inbox_;
  std::shared_ptr<MeshLoader> loader_;
  TopicReceiver receiver_;
  Subscription geometry_;
  Subscription costs_;
  Subscription face_costs_;
  Subscription updates_;
  Subscription colors_;
  Subscription materials_;
  Subscription textures_;
  Subscription labels_;
};

}  // namespace rviz_mesh_plugin
