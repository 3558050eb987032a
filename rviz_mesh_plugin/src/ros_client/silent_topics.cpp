#include "ros_client/silent_topics.h"

#include <algorithm>
#include <utility>

namespace rviz_mesh_plugin {

void SilentTopics::update(Clock::time_point now, const std::vector<std::string>& topics)
{
  std::map<std::string, Clock::time_point> since;
  for (const std::string& topic : topics) {
    const auto before = since_.find(topic);
    since[topic] = before == since_.end() ? now : before->second;
  }
  since_ = std::move(since);
  if (auto types = list_.take()) {
    types_ = std::move(*types);
  }
  const bool due = std::any_of(since_.begin(), since_.end(),
                               [&](const auto& topic) { return now - topic.second >= PATIENCE; });
  const bool rested = !asked_ || now - *asked_ >= INTERVAL;
  if (due && rested && !list_.asking()) {
    asked_ = now;
    list_.ask();
  }
}

std::string SilentTopics::problem(const std::string& topic, const std::string& expected_type) const
{
  const auto type = types_.find(topic);
  // "*": of any type, as relays have it before the first message.
  if (since_.count(topic) == 0 || type == types_.end() || type->second == expected_type ||
      type->second == "*") {
    return std::string();
  }
  return "Topic " + topic + " has type " + type->second + ", expected " + expected_type +
         ": choose another topic";
}

}  // namespace rviz_mesh_plugin
