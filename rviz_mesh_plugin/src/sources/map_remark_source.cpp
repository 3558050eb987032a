#include "sources/map_remark_source.h"

#include <mutex>

#include <ros/exceptions.h>
#include <ros/names.h>
#include <std_msgs/String.h>

namespace rviz_mesh_plugin {

struct MapRemarkSource::Newest
{
  std::mutex mutex;
  std::string text;

  void set(const std::string& newest)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    text = newest;
  }
};

MapRemarkSource::MapRemarkSource() : newest_(std::make_shared<Newest>()) {}

void MapRemarkSource::connect(ros::NodeHandle& node_handle, const std::string& geometry_topic)
{
  std::string topic;
  try {
    if (!geometry_topic.empty()) {
      topic = ros::names::append(
          ros::names::parentNamespace(node_handle.resolveName(geometry_topic)), "remark");
    }
    if (topic == topic_) {
      return;
    }
    disconnect();
    if (topic.empty()) {
      return;
    }
    TopicReceiver::Callbacks<std_msgs::String> callbacks;
    callbacks.receive = [newest = newest_](const auto& message, const auto& /*ended*/) {
      newest->set(message->data);
    };
    callbacks.refuse = [](const std::string& /*reason*/, const auto& /*ended*/) {};
    subscription_ = receiver_.subscribe(node_handle, topic, 1, callbacks);
    topic_ = topic;
  } catch (const ros::Exception&) {
    disconnect();
  }
}

void MapRemarkSource::disconnect()
{
  subscription_.end();
  topic_.clear();
  newest_ = std::make_shared<Newest>();  // what is on its way arrives in the one before
}

OptionalStatus MapRemarkSource::status() const
{
  const std::lock_guard<std::mutex> lock(newest_->mutex);
  if (newest_->text.empty()) {
    return std::nullopt;
  }
  return StatusLine::warn(shortened(newest_->text, 500));
}

}  // namespace rviz_mesh_plugin
