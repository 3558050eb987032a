#include "ros_client/topic_list.h"

#include <exception>
#include <mutex>

#include <ros/console.h>

#include "ros_client/master_call.h"
#include "threads/cancellation.h"
#include "threads/ending_thread.h"

namespace rviz_mesh_plugin {
namespace {

using XmlRpc::XmlRpcValue;

/// From a list of pairs, name and type.
TopicList::Types typesOf(XmlRpcValue list)
{
  const auto is_text = [](const XmlRpcValue& value) {
    return value.getType() == XmlRpcValue::TypeString;
  };
  TopicList::Types types;
  for (int i = 0; list.getType() == XmlRpcValue::TypeArray && i < list.size(); ++i) {
    XmlRpcValue& topic = list[i];
    if (topic.getType() == XmlRpcValue::TypeArray && topic.size() == 2 && is_text(topic[0]) &&
        is_text(topic[1])) {
      types[std::string(topic[0])] = std::string(topic[1]);
    }
  }
  return types;
}

}  // namespace

struct TopicList::Question
{
  Cancellation cancellation;
  std::mutex mutex;
  bool ended = false;
  std::optional<Types> answer;

  void ask()
  {
    std::optional<Types> types;
    try {
      if (const auto list = callMaster("getPublishedTopics", {""}, cancellation)) {
        types = typesOf(*list);
      }
    } catch (const std::exception& error) {
      ROS_DEBUG("no list of topics: %s", error.what());
    }
    const std::lock_guard<std::mutex> lock(mutex);
    answer.swap(types);
    ended = true;
  }
};

TopicList::TopicList() = default;

TopicList::~TopicList()
{
  giveUp();
}

void TopicList::giveUp()
{
  if (question_) {
    question_->cancellation.set();
  }
}

void TopicList::ask()
{
  giveUp();
  question_.reset();
  const auto question = std::make_shared<Question>();
  thread_ = std::make_unique<EndingThread>([question] { question->ask(); });
  question_ = question;
}

bool TopicList::asking() const
{
  if (!question_) {
    return false;
  }
  const std::lock_guard<std::mutex> lock(question_->mutex);
  return !question_->ended;
}

std::optional<TopicList::Types> TopicList::take()
{
  std::optional<Types> taken;
  if (question_) {
    const std::lock_guard<std::mutex> lock(question_->mutex);
    taken.swap(question_->answer);
  }
  return taken;
}

}  // namespace rviz_mesh_plugin
