#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include <actionlib_msgs/GoalStatusArray.h>
#include <geometry_msgs/PoseStamped.h>
#include <mbf_msgs/ExePathActionFeedback.h>
#include <mbf_msgs/ExePathActionGoal.h>
#include <mbf_msgs/ExePathActionResult.h>
#include <mbf_msgs/GetPathActionGoal.h>
#include <mbf_msgs/GetPathActionResult.h>
#include <mbf_msgs/MoveBaseActionFeedback.h>
#include <mbf_msgs/MoveBaseActionGoal.h>
#include <mbf_msgs/MoveBaseActionResult.h>
#include <mbf_msgs/RecoveryActionGoal.h>
#include <nav_msgs/Path.h>

#include "navigation/outcome.h"
#include "navigation/remaining_path.h"

namespace rviz_mesh_plugin {

/// The actions of a server of Move Base Flex.
enum class NavigationAction
{
  MOVE_BASE,
  EXE_PATH,
  GET_PATH,
  RECOVERY
};
constexpr std::size_t ACTION_COUNT = 4;
/// As in the names of topics.
const char* nameOf(NavigationAction action);

/// What a server does.
enum class ServerPhase
{
  NO_SERVER,
  NOT_ANSWERING,
  NOT_READY,  ///< there, and goals wait or are refused
  READY,
  PLANNING,
  DRIVING,
  RECOVERING
};

/// "no server", "planning"
const char* nameOf(ServerPhase phase);

/// Of a process that says nothing: what comes of asking it directly.
enum class ProcessState
{
  UNKNOWN,
  GONE,         ///< nobody is where the ROS master says that it is
  UNREACHABLE,  ///< neither that nor the contrary can be found out
  HANGS,        ///< it takes the question and does not answer
  ANSWERS,      ///< it lives, and yet says nothing
};

/// A goal of move_base, from when it is seen on its way to the server.
struct NavigationGoal
{
  std::string id;
  ros::Time stamp;
  std::optional<geometry_msgs::PoseStamped> target;  ///< nothing: it was sent before anyone looked
  std::string planner;                               ///< as asked for; empty: the server's first
  std::string controller;                            ///< as asked for; empty: the server's first
  std::uint8_t status = actionlib_msgs::GoalStatus::PENDING;
  std::string remark;              ///< what the controller says; empty: all is well
  std::optional<double> distance;  ///< as the server says, in meters: not along the path
  std::optional<Outcome> outcome;  ///< nothing: it has not ended
  bool lost = false;               ///< whether the server did not know it: it may come to do so
};

/// What the messages of one server say together: what it does, why it does not, and what becomes of
/// goals. No ROS, no thread: messages and times are handed in, times of the computer.
class ServerWatch
{
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Actions tell their status five times a second.
  static constexpr std::chrono::seconds SILENCE{3};

  explicit ServerWatch(std::string server) : server_(std::move(server)) {}

  void takeStatus(NavigationAction action, const actionlib_msgs::GoalStatusArray& message,
                  Time now);
  void take(const mbf_msgs::MoveBaseActionGoal& message);
  void take(const mbf_msgs::ExePathActionGoal& message);
  void take(const mbf_msgs::GetPathActionGoal& message);
  void take(const mbf_msgs::RecoveryActionGoal& message);
  void take(const mbf_msgs::MoveBaseActionFeedback& message, Time now);
  void take(const mbf_msgs::ExePathActionFeedback& message, Time now);
  void take(const mbf_msgs::MoveBaseActionResult& message);
  void take(const mbf_msgs::ExePathActionResult& message);
  void take(const mbf_msgs::GetPathActionResult& message);

  /// What the server's own entry on /diagnostics says.
  /// @param ready whether goals are begun; false: they wait, or are refused
  void takeDiagnosis(bool ready, bool well, const std::string& text, Time now);

  /// What the ROS master knows. @param problem why it could not be asked; empty: it was
  void takeListing(bool listed, const std::string& problem);

  /// Of the process; asked for as long as isSilent().
  void takeProcess(ProcessState state) { process_ = state; }

  /// @param stopped whether simulated time stands still: then servers are silent that are well
  void takeClock(bool stopped) { time_stopped_ = stopped; }

  /// Whether nothing of it has been heard for a while.
  bool isSilent(Time now) const { return !heard_ || now - *heard_ >= SILENCE; }

  /// Whether anything of it has ever been heard.
  bool wasHeard() const { return heard_.has_value(); }

  ServerPhase phase(Time now) const;

  /// One sentence: why it does nothing, with the way out; of a server that works, how and why.
  std::string reason(Time now) const;

  /// Whether there is something that can be canceled.
  bool isBusy() const;
  /// Which action drives the robot: where move_base does, the others belong to it.
  bool isBusy(NavigationAction action) const;

  /// The newest one; null: none was seen.
  const NavigationGoal* goal() const { return goal_ ? &*goal_ : nullptr; }
  /// The one that it took the place of; null: none was seen.
  const NavigationGoal* goalBefore() const { return before_ ? &*before_ : nullptr; }

  /// How far it is to the goal that the robot drives to, in meters, and whether that is along the
  /// path.
  struct Remaining
  {
    double length = 0.0;
    bool along_path = false;
    std::optional<double> seconds;
  };
  std::optional<Remaining> remaining() const;

  const std::string& server() const { return server_; }

 private:
  struct ActionRecord
  {
    actionlib_msgs::GoalStatusArray statuses;
    std::optional<Time> heard;
    std::string goal;    ///< id of the last one that was seen on its way; empty: none was
    std::string plugin;  ///< of that one; empty: the server's first
  };
  ActionRecord& of(NavigationAction action) { return actions_[static_cast<std::size_t>(action)]; }
  const ActionRecord& of(NavigationAction action) const
  {
    return actions_[static_cast<std::size_t>(action)];
  }

  void note(NavigationAction action, const actionlib_msgs::GoalID& id, const std::string& plugin);
  std::optional<std::string> pluginOf(NavigationAction action) const;
  std::string describePlugin(NavigationAction action, const char* kind) const;
  void setPath(const nav_msgs::Path& path);
  static void describe(NavigationGoal& goal, const mbf_msgs::MoveBaseGoal& message);
  NavigationGoal* find(const actionlib_msgs::GoalID& id);
  NavigationGoal& begin(const actionlib_msgs::GoalID& id);
  void followStatus(NavigationGoal& goal, const actionlib_msgs::GoalStatusArray& message, Time now);
  void takeFailure(const char* what, const Outcome& outcome);
  template <class Feedback>
  void takeProgress(const Feedback& feedback, Time now);
  std::string silenceReason(Time now) const;

  std::string server_;
  std::array<ActionRecord, ACTION_COUNT> actions_;
  std::optional<Time> heard_;

  std::optional<NavigationGoal> goal_;
  std::optional<NavigationGoal> before_;
  std::optional<mbf_msgs::MoveBaseGoal> unnamed_;  ///< sent without an id, and not seen since
  std::optional<Time> missed_;  ///< since when the goal has ended, or is lost, without a result
  std::string failure_;         ///< of the last step towards it
  RemainingPath remaining_;
  std::optional<double> distance_;

  bool ready_ = true;
  bool well_ = true;
  std::string diagnosis_;
  std::optional<Time> diagnosed_;

  bool listed_ = false;
  std::string listing_problem_;
  bool asked_ = false;
  ProcessState process_ = ProcessState::UNKNOWN;
  bool time_stopped_ = false;
};

}  // namespace rviz_mesh_plugin
