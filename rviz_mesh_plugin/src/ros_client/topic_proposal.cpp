#include "ros_client/topic_proposal.h"

#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>
#include <ros/message_traits.h>

namespace rviz_mesh_plugin {
namespace {

/// Without looking at what the name consists of.
std::string parentOf(const std::string& topic)
{
  return topic.substr(0, topic.rfind('/'));
}

/// A topic of this type in a namespace, the one of this name first; empty where there is none.
template <class Message>
std::string topicIn(const std::string& parent, const char* name, const TopicList::Types& types)
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

void TopicProposal::ask(const std::string& geometry_topic)
{
  parent_ = parentOf(geometry_topic);
  list_.ask();
}

std::optional<TopicProposal::Topics> TopicProposal::take()
{
  const auto types = list_.take();
  if (!types) {
    return std::nullopt;
  }
  return Topics{topicIn<mesh_msgs::MeshVertexCostsStamped>(parent_, "vertex_costs", *types),
                topicIn<mesh_msgs::MeshVertexColorsStamped>(parent_, "vertex_colors", *types)};
}

}  // namespace rviz_mesh_plugin
