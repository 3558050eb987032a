#include "rviz_mesh_plugin/topic_proposal.h"

#include <exception>
#include <mutex>

#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>
#include <ros/console.h>
#include <ros/master.h>
#include <ros/message_traits.h>
#include <ros/names.h>

#include "rviz_mesh_plugin/ending_thread.h"

namespace rviz_mesh_plugin {
namespace {

/// A topic of this type in a namespace, the one of this name first; empty where there is none.
template <class Message>
std::string topicIn(const std::string& parent, const char* name,
                    const ros::master::V_TopicInfo& topics)
{
  std::string found;
  for (const ros::master::TopicInfo& topic : topics) {
    if (topic.datatype == ros::message_traits::datatype<Message>() &&
        ros::names::parentNamespace(topic.name) == parent) {
      if (topic.name == ros::names::append(parent, name)) {
        return topic.name;
      }
      found = found.empty() ? topic.name : found;
    }
  }
  return found;
}

}  // namespace

struct TopicProposal::Answer
{
  std::mutex mutex;
  std::optional<Topics> topics;
};

TopicProposal::TopicProposal() = default;

TopicProposal::~TopicProposal() = default;

void TopicProposal::ask(const std::string& geometry_topic)
{
  const auto answer = std::make_shared<Answer>();
  answer_ = answer;
  thread_ = std::make_unique<EndingThread>([answer, geometry_topic] {
    try {
      ros::master::V_TopicInfo topics;
      if (ros::master::getTopics(topics)) {
        const std::string parent = ros::names::parentNamespace(geometry_topic);
        const Topics found{
            topicIn<mesh_msgs::MeshVertexCostsStamped>(parent, "vertex_costs", topics),
            topicIn<mesh_msgs::MeshVertexColorsStamped>(parent, "vertex_colors", topics)};
        const std::lock_guard<std::mutex> lock(answer->mutex);
        answer->topics = found;
      }
    } catch (const std::exception& error) {  // a topic that is no name, out of memory
      ROS_DEBUG("no topics are proposed for %s: %s", geometry_topic.c_str(), error.what());
    }
  });
}

std::optional<TopicProposal::Topics> TopicProposal::take()
{
  std::optional<Topics> taken;
  if (answer_) {
    const std::lock_guard<std::mutex> lock(answer_->mutex);
    taken.swap(answer_->topics);
  }
  return taken;
}

}  // namespace rviz_mesh_plugin
