#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// What the ROS master knows of the topics that are published, for two questions: why nothing comes
/// from a topic (roscpp only logs where a publisher has another type), and which topics belong to a
/// mesh. GUI thread only; nothing waits for the master.
class TopicDirectory
{
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::seconds PATIENCE{3};  ///< with a topic that is silent
  static constexpr std::chrono::seconds INTERVAL{5};  ///< between two questions to the master

  /// To be called regularly: the master is asked as long as a topic is silent.
  /// @param silent the resolved names of those from which nothing has come so far
  void update(Clock::time_point now, const std::vector<std::string>& silent);

  /// A sentence where a silent topic has another type; else, or where that is not known, empty.
  std::string problem(const std::string& topic, const std::string& expected_type) const;

  /// The topics in the namespace of a mesh's own.
  struct Proposal
  {
    std::string costs;   ///< empty: there are none
    std::string colors;  ///< empty: there are none
  };

  /// Asks the master for those of a mesh. What has been asked for before is given up.
  void propose(const std::string& geometry_topic);

  /// Once, when the master has answered.
  std::optional<Proposal> takeProposal();

  /// Whether an answer of the master is waited for.
  bool asking() const { return question_.isRunning() && !question_.isReady(); }

 private:
  using Types = std::map<std::string, std::string>;  ///< by the name of the topic

  void ask();
  void take();

  std::map<std::string, Clock::time_point> silent_since_;
  std::optional<Clock::time_point> asked_;
  std::optional<std::string> proposed_in_;  ///< the namespace that is asked for
  std::optional<Proposal> proposal_;
  Types types_;
  BackgroundTask<Types> question_{"ROS topics", NAME_PATIENCE};
};

}  // namespace rviz_mesh_plugin
