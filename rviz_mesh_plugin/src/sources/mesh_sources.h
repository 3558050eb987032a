#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "incoming/attribute_queue.h"
#include "incoming/mesh_loader.h"
#include "incoming/reception.h"
#include "ros_client/map_service_client.h"
#include "ros_client/topic_receiver.h"

namespace rviz_mesh_plugin {

/// Where the data of a display come from: its subscriptions and services, and what converts what
/// they bring. Nothing waits for a message that is being read.
class MeshSources
{
 public:
  /// What is subscribed to, and asked for what no topic brings; those without a name are not.
  struct Names
  {
    PerMember<std::string> topics;
    ServiceNames services;
  };

  /// @param with_layouts false: of meshes, there are none
  explicit MeshSources(bool with_layouts = true);

  /// Subscribes to the topics that are named; what came from a topic (or service) that is no longer
  /// named is forgotten, and nothing else: it comes back from no message of the topic before.
  /// @return what was forgotten
  std::vector<MeshMember> connect(ros::NodeHandle& node_handle, const Names& names);

  /// Unsubscribes and gives up what services are asked; nothing is forgotten.
  void disconnect();

  /// Unsubscribes and forgets what has not been taken yet.
  void clear();

  AttributeQueue& queue() { return *queue_; }
  MeshLoader& loader() { return *loader_; }
  MapServiceClient& services() { return services_; }
  const MapServiceClient& services() const { return services_; }

  const std::string& topic(MeshMember part) const { return topics_[part].name; }
  /// As others know it; empty where it is not subscribed to.
  const std::string& resolvedTopic(MeshMember part) const { return topics_[part].resolved; }
  /// Of the messages of a topic.
  static const char* type(MeshMember part);
  /// Why the topic could not be subscribed to; else empty.
  const std::string& error(MeshMember part) const { return topics_[part].error; }

 private:
  struct Topic
  {
    std::string name;
    std::string service;  ///< asked for what no topic brings
    std::string error;
    std::string resolved;
    bool subscribed = false;
    TopicReceiver::Subscription subscription;
  };
  struct Channel;

  static const Channel& channel(MeshMember part);
  template <class Message, std::uint32_t queue_size>
  void subscribe(ros::NodeHandle& node_handle, MeshMember part);
  void forget(MeshMember part);

  std::shared_ptr<AttributeQueue> queue_;
  std::shared_ptr<MeshLoader> loader_;
  MapServiceClient services_;
  TopicReceiver receiver_;
  PerMember<Topic> topics_;
};

}  // namespace rviz_mesh_plugin
