#include "ros_client/topic_directory.h"

#include <algorithm>
#include <utility>

#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>
#include <ros/console.h>
#include <ros/message_traits.h>

#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

using XmlRpc::XmlRpcValue;
using TopicTypes = std::map<std::string, std::string>;

/// From a list of pairs, name and type.
TopicTypes typesOf(XmlRpcValue list)
{
  const auto is_text = [](const XmlRpcValue& value) {
    return value.getType() == XmlRpcValue::TypeString;
  };
  TopicTypes types;
  for (int i = 0; list.getType() == XmlRpcValue::TypeArray && i < list.size(); ++i) {
    XmlRpcValue& topic = list[i];
    if (topic.getType() == XmlRpcValue::TypeArray && topic.size() == 2 && is_text(topic[0]) &&
        is_text(topic[1])) {
      types[std::string(topic[0])] = std::string(topic[1]);
    }
  }
  return types;
}

/// Without looking at what the name consists of.
std::string parentOf(const std::string& topic)
{
  return topic.substr(0, topic.rfind('/'));
}

/// A topic of this type in a namespace, the one of this name first; empty where there is none.
template <class Message>
std::string topicIn(const std::string& parent, const char* name, const TopicTypes& types)
{
  std::string found;
  for (const auto& topic : types) {
    if (topic.second == ros::message_traits::datatype<Message>() &&
        parentOf(topic.first) == parent) {
      if (topic.first == parent + "/" + name) {
        return topic.first;
      }
      found = found.empty() ? topic.first : found;
    }
  }
  return found;
}

}  // namespace

void TopicDirectory::update(Clock::time_point now, const std::vector<std::string>& silent)
{
  std::map<std::string, Clock::time_point> since;
  for (const std::string& topic : silent) {
    const auto before = silent_since_.find(topic);
    since[topic] = before == silent_since_.end() ? now : before->second;
  }
  silent_since_ = std::move(since);
  take();
  const bool due = std::any_of(silent_since_.begin(), silent_since_.end(),
                               [&](const auto& topic) { return now - topic.second >= PATIENCE; });
  const bool rested = !asked_ || now - *asked_ >= INTERVAL;
  if (due && rested && !asking()) {
    asked_ = now;
    ask();
  }
}

std::string TopicDirectory::problem(const std::string& topic,
                                    const std::string& expected_type) const
{
  const auto type = types_.find(topic);
  // "*": of any type, as relays have it before the first message.
  if (silent_since_.count(topic) == 0 || type == types_.end() || type->second == expected_type ||
      type->second == "*") {
    return std::string();
  }
  return "Topic " + topic + " has type " + type->second + ", expected " + expected_type +
         ": choose another topic";
}

void TopicDirectory::propose(const std::string& geometry_topic)
{
  proposed_in_ = parentOf(geometry_topic);
  proposal_.reset();
  ask();
}

std::optional<TopicDirectory::Proposal> TopicDirectory::takeProposal()
{
  take();
  return std::exchange(proposal_, std::nullopt);
}

void TopicDirectory::ask()
{
  question_.start([](const Cancellation& cancellation) {
    const auto list = ServiceCall(cancellation).callMaster("getPublishedTopics", {""});
    return list ? typesOf(*list) : throw ConnectionLost("the ROS master refuses it");
  });
}

void TopicDirectory::take()
{
  auto answer = question_.take();
  if (!answer) {
    return;
  }
  const auto parent = std::exchange(proposed_in_, std::nullopt);
  if (!answer->result) {
    ROS_DEBUG("no list of topics: %s", answer->error.c_str());
    return;
  }
  types_ = std::move(*answer->result);
  if (parent) {
    proposal_ =
        Proposal{topicIn<mesh_msgs::MeshVertexCostsStamped>(*parent, "vertex_costs", types_),
                 topicIn<mesh_msgs::MeshVertexColorsStamped>(*parent, "vertex_colors", types_)};
  }
}

}  // namespace rviz_mesh_plugin
