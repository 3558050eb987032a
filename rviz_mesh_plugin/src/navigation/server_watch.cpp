#include "navigation/server_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/status_lines.h"

namespace rviz_mesh_plugin {
namespace {

using actionlib_msgs::GoalStatus;
using Action = NavigationAction;

/// A result comes at once; it may be lost where a connection has just been made.
constexpr std::chrono::seconds RESULT_PATIENCE(2);
/// Entries on /diagnostics come each second.
constexpr std::chrono::seconds DIAGNOSIS_PERIOD(5);
constexpr std::uint32_t FIRST_ERROR = 10;
constexpr std::size_t MOST_TEXT = 2000;

bool hasEnded(std::uint8_t status)
{
  return status == GoalStatus::PREEMPTED || status == GoalStatus::SUCCEEDED ||
         status == GoalStatus::ABORTED || status == GoalStatus::REJECTED ||
         status == GoalStatus::RECALLED || status == GoalStatus::LOST;
}

std::string orFirst(const std::string& plugin, const char* kind)
{
  return plugin.empty() ? joined("the server's first ", kind) : quotedName(plugin);
}

long secondsBetween(ServerWatch::Time a, ServerWatch::Time b)
{
  return std::chrono::duration_cast<std::chrono::seconds>(b - a).count();
}

}  // namespace

const char* nameOf(NavigationAction action)
{
  const char* const names[ACTION_COUNT] = {"move_base", "exe_path", "get_path", "recovery"};
  return names[static_cast<std::size_t>(action)];
}

const char* nameOf(ServerPhase phase)
{
  switch (phase) {
    case ServerPhase::NO_SERVER:
      return "no server";
    case ServerPhase::NOT_ANSWERING:
      return "not answering";
    case ServerPhase::NOT_READY:
      return "not ready";
    case ServerPhase::READY:
      return "ready";
    case ServerPhase::PLANNING:
      return "planning";
    case ServerPhase::DRIVING:
      return "driving";
    case ServerPhase::RECOVERING:
      return "recovering";
  }
  return "";
}

NavigationGoal* ServerWatch::find(const actionlib_msgs::GoalID& id)
{
  for (auto* goal : {&goal_, &before_}) {
    if (*goal && (*goal)->id == id.id) {
      return &**goal;
    }
  }
  return nullptr;
}

/// A newer goal takes the place of the one before.
NavigationGoal& ServerWatch::begin(const actionlib_msgs::GoalID& id)
{
  before_ = std::move(goal_);
  goal_.emplace();
  goal_->id = id.id;
  goal_->stamp = id.stamp;
  if (unnamed_) {
    describe(*goal_, *std::exchange(unnamed_, std::nullopt));
  }
  missed_.reset();
  failure_.clear();
  distance_.reset();
  remaining_.setPath({}, {});
  return *goal_;
}

void ServerWatch::takeStatus(NavigationAction action,
                             const actionlib_msgs::GoalStatusArray& message, Time now)
{
  of(action).statuses = message;
  of(action).heard = heard_ = now;
  process_ = ProcessState::UNKNOWN;
  if (action != Action::MOVE_BASE) {
    return;
  }
  for (const GoalStatus& status : message.status_list) {
    // One that was sent before anyone looked; those that have ended by then are told by nobody.
    const bool newer = !goal_ || status.goal_id.stamp > goal_->stamp;
    if (!hasEnded(status.status) && newer && !find(status.goal_id)) {
      begin(status.goal_id);
    }
  }
  if (goal_ && (!goal_->outcome || goal_->lost)) {
    followStatus(*goal_, message, now);
  }
}

void ServerWatch::followStatus(NavigationGoal& goal, const actionlib_msgs::GoalStatusArray& message,
                               Time now)
{
  const auto& list = message.status_list;
  const auto found = std::find_if(list.begin(), list.end(), [&](const GoalStatus& status) {
    return status.goal_id.id == goal.id;
  });
  if (found != list.end()) {
    goal.status = found->status;
    if (!hasEnded(goal.status)) {
      missed_.reset();
      goal.outcome.reset();
      goal.lost = false;
      return;
    }
  }
  missed_ = missed_.value_or(now);
  if (now - *missed_ < RESULT_PATIENCE) {
    return;
  }
  Outcome outcome;
  goal.lost = found == list.end();
  if (!goal.lost) {
    const std::uint32_t number = goal.status == GoalStatus::SUCCEEDED ? 0 : FIRST_ERROR;
    outcome = outcomeOf(goal.status, found->text, number, {});
    outcome.name = outcome.succeeded ? "SUCCEEDED" : outcome.name;
  } else {
    outcome.name = "LOST";
    outcome.message =
        "the server knows nothing of this goal: it did not arrive, or the server was "
        "started anew; send it again";
  }
  goal.outcome = outcome;
}

void ServerWatch::take(const mbf_msgs::MoveBaseActionGoal& message)
{
  if (message.goal_id.id.empty()) {  // the server will give it one
    unnamed_ = message.goal;
    return;
  }
  NavigationGoal* goal = find(message.goal_id);
  describe(goal ? *goal : begin(message.goal_id), message.goal);
}

void ServerWatch::describe(NavigationGoal& goal, const mbf_msgs::MoveBaseGoal& message)
{
  goal.target = message.target_pose;
  goal.planner = message.planner;
  goal.controller = message.controller;
}

void ServerWatch::note(Action action, const actionlib_msgs::GoalID& id, const std::string& plugin)
{
  of(action).goal = id.id;
  of(action).plugin = plugin;
}

/// Of what is busy, if it is known: move_base of mesh_navigation begins its goals within the
/// server, and they are not seen on their way.
std::optional<std::string> ServerWatch::pluginOf(Action action) const
{
  const ActionRecord& record = of(action);
  const auto& list = record.statuses.status_list;
  const bool seen = std::any_of(list.begin(), list.end(), [&](const GoalStatus& status) {
    return !hasEnded(status.status) && status.goal_id.id == record.goal;
  });
  if (seen) {
    return record.plugin;
  }
  if (!isBusy(Action::MOVE_BASE) || !goal_ || !goal_->target || goal_->outcome ||
      action == Action::RECOVERY) {
    return std::nullopt;
  }
  return action == Action::EXE_PATH ? goal_->controller : goal_->planner;
}

std::string ServerWatch::describePlugin(Action action, const char* kind) const
{
  const auto plugin = pluginOf(action);
  return plugin ? "with " + orFirst(*plugin, kind) : std::string();
}

void ServerWatch::take(const mbf_msgs::ExePathActionGoal& message)
{
  note(Action::EXE_PATH, message.goal_id, message.goal.controller);
  failure_.clear();
  setPath(message.goal.path);
}

void ServerWatch::setPath(const nav_msgs::Path& path)
{
  std::vector<RemainingPath::Point> points;
  points.reserve(path.poses.size());
  for (const auto& stamped : path.poses) {
    const auto& position = stamped.pose.position;
    points.push_back({position.x, position.y, position.z});
  }
  const bool named = !path.header.frame_id.empty() || path.poses.empty();
  remaining_.setPath(named ? path.header.frame_id : path.poses[0].header.frame_id,
                     std::move(points));
}

void ServerWatch::take(const mbf_msgs::GetPathActionGoal& message)
{
  note(Action::GET_PATH, message.goal_id, message.goal.planner);
}

void ServerWatch::take(const mbf_msgs::RecoveryActionGoal& message)
{
  note(Action::RECOVERY, message.goal_id, message.goal.behavior);
}

template <class Feedback>
void ServerWatch::takeProgress(const Feedback& feedback, Time now)
{
  const auto& position = feedback.current_pose.pose.position;
  remaining_.takePosition(feedback.current_pose.header.frame_id,
                          {position.x, position.y, position.z}, now);
  distance_.reset();
  if (std::isfinite(feedback.dist_to_goal)) {
    distance_ = feedback.dist_to_goal;
  }
}

void ServerWatch::take(const mbf_msgs::MoveBaseActionFeedback& message, Time now)
{
  NavigationGoal* goal = find(message.status.goal_id);
  if (!goal) {
    goal = &begin(message.status.goal_id);
  }
  if (goal != &*goal_ || goal->outcome) {
    return;
  }
  const bool well = message.feedback.outcome < FIRST_ERROR;
  goal->remark = well ? std::string() : nameOfOutcome(message.feedback.outcome);
  if (!well && !message.feedback.message.empty()) {
    goal->remark += ": " + shortened(message.feedback.message, MOST_TEXT);
  }
  takeProgress(message.feedback, now);
  goal->distance = distance_;
}

/// Of a drive alone: that of move_base has its own.
void ServerWatch::take(const mbf_msgs::ExePathActionFeedback& message, Time now)
{
  if (!isBusy(Action::MOVE_BASE)) {
    takeProgress(message.feedback, now);
  }
}

void ServerWatch::take(const mbf_msgs::MoveBaseActionResult& message)
{
  NavigationGoal* goal = find(message.status.goal_id);
  if (!goal) {
    // Results of goals that were never seen are those of long ago, sent to new subscribers.
    if (goal_ && message.status.goal_id.stamp <= goal_->stamp) {
      return;
    }
    goal = &begin(message.status.goal_id);
  }
  goal->status = message.status.status;
  goal->lost = false;
  goal->outcome = outcomeOf(message.status.status, message.status.text, message.result.outcome,
                            message.result.message);
}

void ServerWatch::takeFailure(const char* what, const Outcome& outcome)
{
  using Driving = mbf_msgs::ExePathResult;
  using Planning = mbf_msgs::GetPathResult;
  const bool canceled = outcome.name == nameOfOutcome(Driving::CANCELED) ||
                        outcome.name == nameOfOutcome(Planning::CANCELED);
  // Plans of others are no steps towards the goal.
  if (goal_ && !goal_->outcome && !outcome.succeeded && !canceled) {
    failure_ = joined(what, " failed, ", outcome.text());
  }
}

void ServerWatch::take(const mbf_msgs::ExePathActionResult& message)
{
  takeFailure("driving", outcomeOf(message.status.status, message.status.text,
                                   message.result.outcome, message.result.message));
}

void ServerWatch::take(const mbf_msgs::GetPathActionResult& message)
{
  const Outcome outcome = outcomeOf(message.status.status, message.status.text,
                                    message.result.outcome, message.result.message);
  takeFailure("planning", outcome);
  // Seen on its way: of somebody else, or of a move_base whose drives are seen as well.
  const bool seen = of(Action::GET_PATH).goal == message.status.goal_id.id;
  if (outcome.succeeded && goal_ && !goal_->outcome && !seen) {
    failure_.clear();
    setPath(message.result.path);
  }
}

void ServerWatch::takeDiagnosis(bool ready, bool well, const std::string& text, Time now)
{
  ready_ = ready;
  well_ = well;
  diagnosis_ = shortened(text, MOST_TEXT);
  diagnosed_ = now;
}

void ServerWatch::takeListing(bool listed, const std::string& problem)
{
  asked_ = true;
  listed_ = listed;
  listing_problem_ = problem;
}

bool ServerWatch::isBusy(NavigationAction action) const
{
  const auto& list = of(action).statuses.status_list;
  return std::any_of(list.begin(), list.end(),
                     [](const GoalStatus& status) { return !hasEnded(status.status); });
}

bool ServerWatch::isBusy() const
{
  return isBusy(Action::MOVE_BASE) || isBusy(Action::EXE_PATH) || isBusy(Action::GET_PATH) ||
         isBusy(Action::RECOVERY);
}

ServerPhase ServerWatch::phase(Time now) const
{
  if (isSilent(now)) {
    const bool there = process_ == ProcessState::HANGS || process_ == ProcessState::ANSWERS;
    const bool may_be_there =
        heard_ && (process_ == ProcessState::UNKNOWN || process_ == ProcessState::UNREACHABLE);
    return there || may_be_there ? ServerPhase::NOT_ANSWERING : ServerPhase::NO_SERVER;
  }
  if (isBusy(Action::RECOVERY)) {
    return ServerPhase::RECOVERING;
  }
  if (isBusy(Action::EXE_PATH)) {
    return ServerPhase::DRIVING;
  }
  const bool known = diagnosed_ && now - *diagnosed_ < DIAGNOSIS_PERIOD;
  if (known && !ready_) {
    return ServerPhase::NOT_READY;
  }
  return isBusy(Action::GET_PATH) || isBusy(Action::MOVE_BASE) ? ServerPhase::PLANNING
                                                               : ServerPhase::READY;
}

std::string ServerWatch::silenceReason(Time now) const
{
  const std::string since =
      heard_ ? joined(", silent for ", secondsBetween(*heard_, now), " s") : std::string();
  const bool busy = isBusy();
  const std::string danger =
      busy ? " It was at work: what the robot does now is not known." : std::string();
  switch (process_) {
    case ProcessState::GONE:
      return joined("The process of ", server_, " is gone", since,
                    ": start it again (roslaunch mesh_navigation mesh_navigation.launch).", danger);
    case ProcessState::UNREACHABLE:
      return joined(server_, " cannot be reached", since,
                    listing_problem_.empty() ? std::string() : ": " + listing_problem_,
                    ". It may go on without being heard: look after network and ROS master.",
                    danger);
    case ProcessState::HANGS:
      return joined("The process of ", server_, " is there and does not answer", since,
                    ": it hangs, is stopped, or is too busy. Wait, or end it and start it again.",
                    danger);
    case ProcessState::ANSWERS:
      return time_stopped_
                 ? joined("Simulated time stands still, and with it ", server_, since,
                          ": /use_sim_time is set, and nobody publishes on /clock.", danger)
                 : joined("The process of ", server_, " answers, but its actions tell no status",
                          since, ": its log may say why.", danger);
    case ProcessState::UNKNOWN:
      break;
  }
  if (!listing_problem_.empty()) {
    return joined("It is not known whether there is a server: ", listing_problem_, danger);
  }
  if (heard_) {
    return joined(server_, " says nothing any more", since, ".", danger);
  }
  if (!asked_) {
    return "The ROS master is being asked.";
  }
  return listed_ ? joined("Nothing has come from ", server_, " yet.")
                 : joined("There is no action server ", server_,
                          "/move_base: start one (roslaunch mesh_navigation "
                          "mesh_navigation.launch), or choose another one above.");
}

std::string ServerWatch::reason(Time now) const
{
  const auto with = [&](Action action, const char* kind, const char* between,
                        const std::string& more) {
    const std::string plugin = describePlugin(action, kind);
    return plugin.empty() || more.empty() ? plugin + more : plugin + between + more;
  };
  const std::string because = failure_.empty() ? std::string() : "since " + failure_;
  switch (phase(now)) {
    case ServerPhase::NO_SERVER:
    case ServerPhase::NOT_ANSWERING:
      return silenceReason(now);
    case ServerPhase::NOT_READY:
      return (isBusy() ? "The goal waits: " : "Goals wait or are refused: ") + diagnosis_;
    case ServerPhase::RECOVERING:
      return with(Action::RECOVERY, "behavior", ", ", because);
    case ServerPhase::DRIVING:
      return with(Action::EXE_PATH, "controller", ": ",
                  goal_ && !goal_->outcome ? goal_->remark : std::string());
    case ServerPhase::PLANNING:
      return with(Action::GET_PATH, "planner", ", ", because);
    case ServerPhase::READY:
      break;
  }
  const bool known = diagnosed_ && now - *diagnosed_ < DIAGNOSIS_PERIOD;
  return known && !well_ ? diagnosis_ : std::string();
}

std::optional<ServerWatch::Remaining> ServerWatch::remaining() const
{
  const bool over = goal_ && goal_->outcome && !isBusy(Action::EXE_PATH);
  if (over || !isBusy()) {
    return std::nullopt;
  }
  const auto along = remaining_.length();
  if (!along && !distance_) {
    return std::nullopt;
  }
  Remaining remaining;
  remaining.length = along ? *along : *distance_;
  remaining.along_path = along.has_value();
  remaining.seconds = remaining_.timeFor(remaining.length);
  return remaining;
}

}  // namespace rviz_mesh_plugin
