#pragma once

#include <memory>
#include <mutex>
#include <string>

#include <ros/exceptions.h>
#include <ros/names.h>
#include <ros/node_handle.h>

#include "ros_client/topic_receiver.h"

namespace rviz_mesh_plugin {

/// A latched topic on which the node that publishes a mesh says more of it, beside that of the
/// geometry: mesh_map does so on "remark" and "layer_info". GUI thread only.
template <class Message>
class MapTopic
{
 public:
  using ConstPtr = typename Message::ConstPtr;

  /// @param name of the topic, in the namespace of that of the geometry
  explicit MapTopic(std::string name) : name_(std::move(name)), newest_(std::make_shared<Newest>())
  {
  }

  /// Follows what is said beside this topic; nothing happens where it does so already, and where
  /// it is empty, nothing is followed. A name that is none is said where the geometry is
  /// subscribed to.
  void connect(ros::NodeHandle& node_handle, const std::string& geometry_topic)
  {
    std::string topic;
    try {
      if (!geometry_topic.empty()) {
        topic = ros::names::append(
            ros::names::parentNamespace(node_handle.resolveName(geometry_topic)), name_);
      }
      if (topic == topic_) {
        return;
      }
      disconnect();
      if (topic.empty()) {
        return;
      }
      typename TopicReceiver::Callbacks<Message> callbacks;
      callbacks.receive = [newest = newest_](const ConstPtr& message, const auto& /*ended*/) {
        const std::lock_guard<std::mutex> lock(newest->mutex);
        newest->message = message;
      };
      callbacks.refuse = [](const std::string& /*reason*/, const auto& /*ended*/) {};
      subscription_ = receiver_.subscribe(node_handle, topic, 1, callbacks);
      topic_ = topic;
    } catch (const ros::Exception&) {
      disconnect();
    }
  }

  void disconnect()
  {
    subscription_.end();
    topic_.clear();
    newest_ = std::make_shared<Newest>();  // what is on its way arrives in the one before
  }

  /// The newest message; null where none has come.
  ConstPtr newest() const
  {
    const std::lock_guard<std::mutex> lock(newest_->mutex);
    return newest_->message;
  }

 private:
  struct Newest
  {
    std::mutex mutex;
    ConstPtr message;
  };

  std::string name_;
  std::string topic_;  ///< empty: not connected
  TopicReceiver receiver_;
  TopicReceiver::Subscription subscription_;
  std::shared_ptr<Newest> newest_;
};

}  // namespace rviz_mesh_plugin
