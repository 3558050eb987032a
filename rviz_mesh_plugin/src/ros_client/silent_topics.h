#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ros_client/topic_list.h"

namespace rviz_mesh_plugin {

/// Finds out why nothing comes from topics: roscpp only logs where a publisher has another type.
/// The master is asked as long as a topic is silent. GUI thread only, and never waits.
class SilentTopics
{
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::seconds PATIENCE{3};  ///< with a topic that is silent
  static constexpr std::chrono::seconds INTERVAL{5};  ///< between two questions to the master

  /// To be called regularly.
  /// @param topics the resolved names of those from which nothing has come so far
  void update(Clock::time_point now, const std::vector<std::string>& topics);

  /// A sentence where a silent topic has another type; else, or where that is not known, empty.
  std::string problem(const std::string& topic, const std::string& expected_type) const;

  /// Whether an answer of the master is waited for.
  bool asking() const { return list_.asking(); }

 private:
  std::map<std::string, Clock::time_point> since_;  ///< when they were silent first
  std::optional<Clock::time_point> asked_;
  TopicList list_;
  TopicList::Types types_;
};

}  // namespace rviz_mesh_plugin
