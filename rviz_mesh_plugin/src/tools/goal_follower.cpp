#include "tools/goal_follower.h"

#include <cstdio>
#include <exception>
#include <utility>
#include <vector>

#include <ros/console.h>
#include <QTimer>

#include "base/status_lines.h"

namespace rviz_mesh_plugin {
namespace {

constexpr int PERIOD = 100;  // milliseconds
/// So many servers are looked at; who has more chooses one in the panel.
constexpr std::size_t MOST_SERVERS = 8;
/// Until somebody has made an action goal of what was published.
constexpr std::chrono::seconds TAKING_PATIENCE(3);
/// A goal that nobody has taken until then is somebody's later one.
constexpr std::chrono::seconds SEARCH_PERIOD(15);
/// An outcome is said once more after so long.
constexpr std::chrono::seconds OUTCOME_AGAIN(2);
constexpr std::chrono::milliseconds REPETITION(500);
/// Nobody is looked at any more after so long without a goal.
constexpr std::chrono::seconds REST(60);
constexpr std::size_t MOST_TEXT = 250;  // characters: the panel says all of it

/// Who passes it on in another frame has changed its numbers: then the stamp says it, or that it
/// comes soon.
bool isSame(const geometry_msgs::PoseStamped& a, const geometry_msgs::PoseStamped& b, bool soon)
{
  if (a.header.frame_id != b.header.frame_id) {
    return soon || a.header.stamp == b.header.stamp;
  }
  const auto& p = a.pose.position;
  const auto& q = b.pose.position;
  return p.x == q.x && p.y == q.y && p.z == q.z;
}

std::string describe(const ServerWatch::Remaining& remaining)
{
  char text[96];
  std::snprintf(text, sizeof(text), ", %.1f m to go%s", remaining.length,
                remaining.along_path ? " along the path" : "");
  std::string described = text;
  if (remaining.seconds) {
    std::snprintf(text, sizeof(text), ", about %.0f s", *remaining.seconds);
    described += text;
  }
  return described;
}

}  // namespace

GoalFollower::GoalFollower(Say say, std::function<bool()> may_say)
    : say_(std::move(say)), may_say_(std::move(may_say)), timer_(new QTimer(this))
{
  connect(timer_, &QTimer::timeout, this, [this] { work(); });
}

GoalFollower::~GoalFollower() = default;

void GoalFollower::prepare()
{
  released_ = false;
  outcome_.clear();
  used_ = std::chrono::steady_clock::now();
  timer_->start(PERIOD);
}

void GoalFollower::follow(const geometry_msgs::PoseStamped& goal, const std::string& topic)
{
  prepare();
  Followed followed;
  followed.goal = goal;
  followed.topic = topic;
  followed.since = used_;
  for (const auto& server : servers_) {
    const ServerWatch& watch = server.second->watch();
    for (const NavigationGoal* older : {watch.goal(), watch.goalBefore()}) {
      if (older) {
        followed.older.insert(older->id);
      }
    }
  }
  followed_ = followed;
  said_.clear();
}

void GoalFollower::work()
{
  const Time now = std::chrono::steady_clock::now();
  try {
    followServers(now);
    find(now);
    tell(now);
    if (!outcome_.empty() && released_ && now - outcome_at_ >= OUTCOME_AGAIN) {
      said_at_ = now;
      say_(std::exchange(outcome_, std::string()));
    }
  } catch (const std::exception& error) {
    ROS_ERROR_THROTTLE(10, "what becomes of a goal cannot be told: %s", error.what());
  }
  if (released_ && !followed_ && outcome_.empty() && now - used_ > REST) {
    timer_->stop();
    servers_.clear();
  }
}

void GoalFollower::followServers(Time now)
{
  directory_.update(now, std::string());
  for (const std::string& name : directory_.servers()) {
    if (servers_.count(name) == 0 && servers_.size() < MOST_SERVERS) {
      servers_.emplace(name, std::make_unique<NavigationServer>(name));
    }
  }
  for (const auto& server : servers_) {
    server.second->work(directory_, now);
  }
}

void GoalFollower::find(Time now)
{
  if (!followed_ || followed_->server) {
    return;
  }
  const bool soon = now - followed_->since < TAKING_PATIENCE;
  bool any_speaks = false;
  // Those whose target was sent before this had connected to their server.
  std::vector<std::pair<const NavigationServer*, std::string>> unseen;
  for (const auto& server : servers_) {
    const ServerWatch& watch = server.second->watch();
    any_speaks = any_speaks || !watch.isSilent(now);
    for (const NavigationGoal* goal : {watch.goal(), watch.goalBefore()}) {
      if (!goal || followed_->older.count(goal->id) != 0) {
        continue;
      }
      if (goal->target && isSame(*goal->target, followed_->goal, soon)) {
        followed_->server = server.second.get();
        followed_->id = goal->id;
        return;
      }
      if (!goal->target && goal->stamp >= followed_->goal.header.stamp) {
        unseen.emplace_back(server.second.get(), goal->id);
      }
    }
  }
  if (!soon && unseen.size() == 1 && !followed_->doubted) {
    followed_->server = unseen[0].first;
    followed_->id = unseen[0].second;
  } else if (!soon && unseen.empty() && !followed_->doubted) {
    doubt(any_speaks, now);
  } else if (now - followed_->since >= SEARCH_PERIOD) {
    followed_.reset();
  }
}

void GoalFollower::doubt(bool any_speaks, Time now)
{
  followed_->doubted = true;
  const char* why =
      ", but no navigation server has got it: does goal_bridge run, and does its parameter "
      "goal_topic name this topic?";
  if (!any_speaks && !directory_.problem().empty()) {
    tellOutcome(
        joined("The goal was published on ", followed_->topic,
               ", but whether there is a navigation server is not known: ", directory_.problem()),
        now);
    return;
  }
  if (servers_.empty()) {
    why =
        ", but there is no navigation server: start one (roslaunch mesh_navigation "
        "mesh_navigation.launch).";
  } else if (!any_speaks) {
    why = ", but no navigation server says anything: the panel MeshNavigation may tell why.";
  }
  tellOutcome("The goal was published on " + followed_->topic + why, now);
}

void GoalFollower::tell(Time now)
{
  if (!followed_ || !followed_->server) {
    return;
  }
  const ServerWatch& watch = followed_->server->watch();
  const NavigationGoal* goal = watch.goal();
  const bool replaced = !goal || goal->id != followed_->id;
  if (replaced) {
    goal = watch.goalBefore();
  }
  used_ = now;
  if (!goal || goal->id != followed_->id) {
    tellOutcome("The goal was replaced by newer ones", now);
    followed_.reset();
  } else if (goal->outcome) {
    tellOutcome(
        (goal->outcome->succeeded ? "The goal was reached: " : "The goal was not reached: ") +
            goal->outcome->text(),
        now);
    followed_.reset();
  } else if (released_ && may_say_() && !replaced && now - said_at_ >= REPETITION) {
    std::string text = joined("Goal: ", nameOf(watch.phase(now)));
    if (const auto remaining = watch.remaining()) {
      text += describe(*remaining);
    }
    const std::string reason = watch.reason(now);
    text += reason.empty() ? "" : "; " + reason;
    said_at_ = now;
    say_(shortened(text, MOST_TEXT));
  }
}

void GoalFollower::tellOutcome(const std::string& text, Time now)
{
  outcome_ = shortened(text, MOST_TEXT);
  outcome_at_ = said_at_ = now;
  say_(outcome_);
}

}  // namespace rviz_mesh_plugin
