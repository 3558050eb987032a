#include "navigation/server_watch.h"

#include <chrono>
#include <limits>
#include <string>

#include <gtest/gtest.h>

using namespace rviz_mesh_plugin;
using actionlib_msgs::GoalStatus;
using std::chrono::milliseconds;
using std::chrono::seconds;

namespace {

using Action = NavigationAction;
using Phase = ServerPhase;

/// A server whose messages are made by hand, and a clock that is set by hand.
class ServerWatchTest : public testing::Test
{
 protected:
  static actionlib_msgs::GoalID id(const std::string& name, int stamp)
  {
    actionlib_msgs::GoalID made;
    made.id = name;
    made.stamp = ros::Time(stamp, 0);
    return made;
  }

  void tell(Action action, const std::vector<std::pair<actionlib_msgs::GoalID, int>>& goals = {})
  {
    actionlib_msgs::GoalStatusArray message;
    for (const auto& goal : goals) {
      GoalStatus status;
      status.goal_id = goal.first;
      status.status = static_cast<std::uint8_t>(goal.second);
      message.status_list.push_back(status);
    }
    watch.takeStatus(action, message, now);
  }

  void sendGoal(const actionlib_msgs::GoalID& goal, const std::string& planner = "")
  {
    mbf_msgs::MoveBaseActionGoal message;
    message.goal_id = goal;
    message.goal.planner = planner;
    message.goal.target_pose.header.frame_id = "map";
    watch.take(message);
  }

  void sendResult(const actionlib_msgs::GoalID& goal, int status, unsigned outcome,
                  const std::string& text)
  {
    mbf_msgs::MoveBaseActionResult message;
    message.status.goal_id = goal;
    message.status.status = static_cast<std::uint8_t>(status);
    message.result.outcome = outcome;
    message.result.message = text;
    watch.take(message);
  }

  void failPlan(unsigned outcome, const std::string& text)
  {
    mbf_msgs::GetPathActionResult message;
    message.status.status = GoalStatus::ABORTED;
    message.result.outcome = outcome;
    message.result.message = text;
    watch.take(message);
  }

  static nav_msgs::Path pathOf(const std::vector<std::array<double, 2>>& points)
  {
    nav_msgs::Path path;
    path.header.frame_id = "map";
    for (const auto& point : points) {
      geometry_msgs::PoseStamped pose;
      pose.pose.position.x = point[0];
      pose.pose.position.y = point[1];
      path.poses.push_back(pose);
    }
    return path;
  }

  void sendPath(const std::vector<std::array<double, 2>>& points, const std::string& goal)
  {
    mbf_msgs::ExePathActionGoal message;
    message.goal_id = id(goal, 1);
    message.goal.path = pathOf(points);
    watch.take(message);
  }

  void sendPlan(const std::vector<std::array<double, 2>>& points, const std::string& goal)
  {
    mbf_msgs::GetPathActionResult message;
    message.status.goal_id = id(goal, 1);
    message.status.status = GoalStatus::SUCCEEDED;
    message.result.path = pathOf(points);
    watch.take(message);
  }

  void sendFeedback(const actionlib_msgs::GoalID& goal, double x, double y, double distance,
                    unsigned outcome = 0, const std::string& text = "")
  {
    mbf_msgs::MoveBaseActionFeedback message;
    message.status.goal_id = goal;
    message.feedback.outcome = outcome;
    message.feedback.message = text;
    message.feedback.dist_to_goal = static_cast<float>(distance);
    message.feedback.current_pose.header.frame_id = "map";
    message.feedback.current_pose.pose.position.x = x;
    message.feedback.current_pose.pose.position.y = y;
    watch.take(message, now);
  }

  bool says(const std::string& text) const
  {
    return watch.reason(now).find(text) != std::string::npos;
  }

  ServerWatch watch{"/move_base_flex"};
  ServerWatch::Time now{seconds(1000)};
};

TEST_F(ServerWatchTest, no_server_a_silent_one_a_dead_one_and_one_that_hangs)
{
  EXPECT_EQ(watch.phase(now), Phase::NO_SERVER);
  watch.takeListing(false, "");
  EXPECT_TRUE(says("no action server /move_base_flex/move_base: start one")) << watch.reason(now);
  watch.takeListing(false, "nobody answers at 127.0.0.1");
  EXPECT_TRUE(says("not known whether there is a server: nobody answers")) << watch.reason(now);
  watch.takeListing(true, "");
  tell(Action::MOVE_BASE);
  EXPECT_EQ(watch.phase(now), Phase::READY);
  EXPECT_EQ(watch.reason(now), "");
  now += milliseconds(2900);
  EXPECT_EQ(watch.phase(now), Phase::READY);
  now += seconds(4);
  EXPECT_EQ(watch.phase(now), Phase::NOT_ANSWERING);
  EXPECT_TRUE(says("silent for 6 s")) << watch.reason(now);
  watch.takeProcess(ProcessState::HANGS);
  EXPECT_EQ(watch.phase(now), Phase::NOT_ANSWERING);
  EXPECT_TRUE(says("is there and does not answer")) << watch.reason(now);
  watch.takeProcess(ProcessState::ANSWERS);
  EXPECT_TRUE(says("its actions tell no status")) << watch.reason(now);
  watch.takeClock(true);
  EXPECT_TRUE(says("nobody publishes on /clock")) << watch.reason(now);
  watch.takeProcess(ProcessState::UNREACHABLE);
  EXPECT_EQ(watch.phase(now), Phase::NOT_ANSWERING);
  EXPECT_TRUE(says("cannot be reached, silent for 6 s")) << watch.reason(now);
  EXPECT_FALSE(says("start it again")) << watch.reason(now);
  watch.takeProcess(ProcessState::GONE);
  EXPECT_EQ(watch.phase(now), Phase::NO_SERVER);
  EXPECT_TRUE(says("is gone, silent for 6 s: start it again")) << watch.reason(now);
  tell(Action::GET_PATH);  // another one of that name
  EXPECT_EQ(watch.phase(now), Phase::READY);
}

TEST_F(ServerWatchTest, a_server_that_falls_silent_at_work_is_a_danger)
{
  tell(Action::EXE_PATH, {{id("a", 1), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.phase(now), Phase::DRIVING);
  now += seconds(5);
  watch.takeProcess(ProcessState::GONE);
  EXPECT_TRUE(says("what the robot does now is not known")) << watch.reason(now);
}

TEST_F(ServerWatchTest, what_a_goal_goes_through)
{
  const auto goal = id("a", 1);
  tell(Action::MOVE_BASE);
  sendGoal(goal, "dijkstra");
  ASSERT_TRUE(watch.goal());
  EXPECT_EQ(watch.goal()->planner, "dijkstra");
  EXPECT_FALSE(watch.isBusy()) << "it may not have arrived yet";
  tell(Action::MOVE_BASE, {{goal, GoalStatus::ACTIVE}});
  EXPECT_TRUE(watch.isBusy());
  EXPECT_EQ(watch.phase(now), Phase::PLANNING);
  mbf_msgs::GetPathActionGoal plan;
  plan.goal_id = id("move_base-1", 1);
  plan.goal.planner = "dijkstra";
  watch.take(plan);
  tell(Action::GET_PATH, {{id("move_base-1", 1), GoalStatus::ACTIVE}});
  EXPECT_TRUE(says("with 'dijkstra'")) << watch.reason(now);
  EXPECT_FALSE(watch.remaining());

  sendPath({{0, 0}, {4, 0}, {4, 3}}, "move_base-2");
  tell(Action::GET_PATH);
  tell(Action::EXE_PATH, {{id("move_base-2", 1), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.phase(now), Phase::DRIVING);
  EXPECT_TRUE(says("with the server's first controller")) << watch.reason(now);
  sendFeedback(goal, 0, 0.1, 5.0);
  ASSERT_TRUE(watch.remaining());
  EXPECT_TRUE(watch.remaining()->along_path);
  EXPECT_NEAR(watch.remaining()->length, 7.0, 1e-9) << "and not the 5 m straight on";
  EXPECT_FALSE(watch.remaining()->seconds) << "it has not moved yet";
  for (int i = 1; i <= 4; ++i) {
    now += seconds(1);
    sendFeedback(goal, 0.5 * i, 0.1, 5.0);
  }
  EXPECT_NEAR(watch.remaining()->length, 5.0, 1e-9);
  EXPECT_NEAR(watch.remaining()->seconds.value_or(0), 10.0, 1e-6) << "at 0.5 m/s";
  tell(Action::EXE_PATH, {{id("move_base-2", 1), GoalStatus::ACTIVE}});
  sendFeedback(goal, 2, 0, 5.0, 109, "a chair is on the path");
  EXPECT_TRUE(says("BLOCKED_PATH (109): a chair is on the path")) << watch.reason(now);

  tell(Action::EXE_PATH);
  tell(Action::MOVE_BASE, {{goal, GoalStatus::SUCCEEDED}});
  sendResult(goal, GoalStatus::SUCCEEDED, 0, "there");
  EXPECT_EQ(watch.phase(now), Phase::READY);
  ASSERT_TRUE(watch.goal()->outcome);
  EXPECT_TRUE(watch.goal()->outcome->succeeded);
  EXPECT_EQ(watch.goal()->outcome->text(), "SUCCESS (0): there");
  EXPECT_FALSE(watch.remaining());
}

TEST_F(ServerWatchTest, why_the_robot_backs_up)
{
  const auto goal = id("a", 1);
  sendGoal(goal);
  tell(Action::MOVE_BASE, {{goal, GoalStatus::ACTIVE}});
  failPlan(53, "the goal is blocked by steepness");
  mbf_msgs::RecoveryActionGoal recovery;
  recovery.goal_id = id("move_base-3", 1);
  recovery.goal.behavior = "back_up";
  watch.take(recovery);
  tell(Action::RECOVERY, {{id("move_base-3", 1), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.phase(now), Phase::RECOVERING);
  EXPECT_EQ(watch.reason(now),
            "with 'back_up', since planning failed, INVALID_GOAL (53): the goal is blocked by "
            "steepness");
  sendResult(goal, GoalStatus::ABORTED, 53, "the goal is blocked by steepness; in vain");
  EXPECT_EQ(watch.goal()->outcome->name, "INVALID_GOAL (53)");
  EXPECT_FALSE(watch.goal()->outcome->succeeded);
  // A plan of somebody else's that fails is no step towards a goal.
  failPlan(54, "no path for somebody else");
  tell(Action::RECOVERY, {{id("another", 5), GoalStatus::ACTIVE}});
  EXPECT_FALSE(says("somebody else")) << watch.reason(now);
}

TEST_F(ServerWatchTest, what_move_base_begins_within_the_server_is_known_by_its_plans)
{
  const auto goal = id("a", 1);
  sendGoal(goal, "dijkstra");
  tell(Action::MOVE_BASE, {{goal, GoalStatus::ACTIVE}});
  tell(Action::GET_PATH, {{id("move_base-1", 1), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.reason(now), "with 'dijkstra'") << "as the goal asks for";
  failPlan(54, "no way yet");
  EXPECT_TRUE(says("since planning failed")) << watch.reason(now);
  sendPlan({{0, 0}, {4, 0}, {4, 3}}, "move_base-1");
  tell(Action::GET_PATH);
  tell(Action::EXE_PATH, {{id("move_base-2", 1), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.reason(now), "with the server's first controller");
  sendFeedback(goal, 0, 0, 5.0);
  ASSERT_TRUE(watch.remaining());
  EXPECT_TRUE(watch.remaining()->along_path);
  EXPECT_NEAR(watch.remaining()->length, 7.0, 1e-9);
  // What somebody else has planned was seen on its way, and is no path of the robot's.
  mbf_msgs::GetPathActionGoal other;
  other.goal_id = id("other", 1);
  watch.take(other);
  sendPlan({{0, 0}, {90, 0}}, "other");
  EXPECT_NEAR(watch.remaining()->length, 7.0, 1e-9);
  sendPlan({{0, 0}, {5, 0}}, "move_base-3");
  EXPECT_NEAR(watch.remaining()->length, 5.0, 1e-9) << "planned anew";
  tell(Action::RECOVERY, {{id("move_base-4", 1), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.reason(now), "") << "which behavior that is, nobody says";
}

TEST_F(ServerWatchTest, plugins_that_are_not_known_are_not_told)
{
  mbf_msgs::ExePathActionGoal before;
  before.goal_id = id("of yesterday", 1);
  before.goal.controller = "another";
  watch.take(before);
  tell(Action::MOVE_BASE, {{id("a", 2), GoalStatus::ACTIVE}});
  tell(Action::GET_PATH, {{id("move_base-1", 2), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.phase(now), Phase::PLANNING);
  EXPECT_EQ(watch.reason(now), "");
  tell(Action::EXE_PATH, {{id("move_base-2", 2), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.phase(now), Phase::DRIVING);
  EXPECT_EQ(watch.reason(now), "");
}

TEST_F(ServerWatchTest, a_goal_that_was_thought_lost_and_one_without_an_id)
{
  sendGoal(id("late", 1));
  tell(Action::MOVE_BASE);
  now += seconds(3);
  tell(Action::MOVE_BASE);
  ASSERT_TRUE(watch.goal()->outcome);
  tell(Action::MOVE_BASE, {{id("late", 1), GoalStatus::ACTIVE}});
  EXPECT_FALSE(watch.goal()->outcome) << "it was only late";
  sendResult(id("late", 1), GoalStatus::SUCCEEDED, 0, "there");
  sendGoal(id("", 0), "dijkstra");
  EXPECT_EQ(watch.goal()->id, "late") << "the server will give it an id";
  tell(Action::MOVE_BASE, {{id("move_base_flex-7", 3), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.goal()->id, "move_base_flex-7");
  EXPECT_EQ(watch.goal()->planner, "dijkstra");
  EXPECT_TRUE(watch.goal()->target);
  EXPECT_EQ(watch.goalBefore()->id, "late");
}

TEST_F(ServerWatchTest, of_two_goals_the_newer_one_counts_and_the_older_ones_outcome_is_kept)
{
  const auto first = id("a", 1), second = id("b", 2);
  sendGoal(first);
  tell(Action::MOVE_BASE, {{first, GoalStatus::ACTIVE}});
  sendGoal(second);
  sendResult(first, GoalStatus::PREEMPTED, 11, "a newer goal took slot 0");
  EXPECT_EQ(watch.goal()->id, "b");
  EXPECT_FALSE(watch.goal()->outcome) << "that was the other one's";
  ASSERT_TRUE(watch.goalBefore() && watch.goalBefore()->outcome);
  EXPECT_EQ(watch.goalBefore()->outcome->text(), "CANCELED (11): a newer goal took slot 0");
  tell(Action::MOVE_BASE, {{first, GoalStatus::PREEMPTED}, {second, GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.goal()->id, "b");
  sendResult(id("c", 0), GoalStatus::ABORTED, 10, "of long ago, sent to a new subscriber");
  EXPECT_EQ(watch.goal()->id, "b");
}

TEST_F(ServerWatchTest, a_goal_that_was_sent_before_anyone_looked_is_known_by_its_status)
{
  tell(Action::MOVE_BASE, {{id("old", 1), GoalStatus::ABORTED}});
  EXPECT_FALSE(watch.goal()) << "it has ended, and nobody tells how";
  tell(Action::MOVE_BASE, {{id("old", 1), GoalStatus::ABORTED}, {id("a", 2), GoalStatus::ACTIVE}});
  ASSERT_TRUE(watch.goal());
  EXPECT_EQ(watch.goal()->id, "a");
  EXPECT_FALSE(watch.goal()->target);
  sendFeedback(id("a", 2), 0, 0, 2.5);
  EXPECT_NEAR(watch.remaining()->length, 2.5, 1e-6);
  EXPECT_FALSE(watch.remaining()->along_path);
}

TEST_F(ServerWatchTest, a_result_that_is_lost_and_a_goal_that_nobody_knows_are_told)
{
  const auto goal = id("a", 1);
  sendGoal(goal);
  tell(Action::MOVE_BASE, {{goal, GoalStatus::ABORTED}});
  EXPECT_FALSE(watch.goal()->outcome) << "its result may still come";
  now += seconds(3);
  actionlib_msgs::GoalStatusArray message;
  message.status_list.resize(1);
  message.status_list[0].goal_id = goal;
  message.status_list[0].status = GoalStatus::ABORTED;
  message.status_list[0].text = "no ground";
  watch.takeStatus(Action::MOVE_BASE, message, now);
  ASSERT_TRUE(watch.goal()->outcome);
  EXPECT_EQ(watch.goal()->outcome->message, "no ground");
  EXPECT_FALSE(watch.goal()->outcome->succeeded);
  sendGoal(id("b", 2));
  tell(Action::MOVE_BASE);
  now += seconds(3);
  tell(Action::MOVE_BASE);
  ASSERT_TRUE(watch.goal()->outcome);
  EXPECT_EQ(watch.goal()->outcome->name, "LOST");
}

TEST_F(ServerWatchTest, what_the_server_says_of_itself)
{
  tell(Action::MOVE_BASE);
  watch.takeDiagnosis(false, false, "the map is still being loaded, for 12 s now", now);
  EXPECT_EQ(watch.phase(now), Phase::NOT_READY);
  EXPECT_TRUE(says("Goals wait or are refused: the map is still being loaded"))
      << watch.reason(now);
  tell(Action::MOVE_BASE, {{id("a", 1), GoalStatus::ACTIVE}});
  EXPECT_EQ(watch.phase(now), Phase::NOT_READY);
  EXPECT_TRUE(says("The goal waits: the map is")) << watch.reason(now);
  watch.takeDiagnosis(true, false, "planner x cannot be used", now);
  tell(Action::MOVE_BASE);
  EXPECT_EQ(watch.phase(now), Phase::READY);
  EXPECT_TRUE(says("planner x cannot be used"));
  watch.takeDiagnosis(true, true, "ready, 3 layers", now);
  EXPECT_EQ(watch.reason(now), "");
  watch.takeDiagnosis(false, false, "the map is gone", now);
  now += seconds(6);
  tell(Action::MOVE_BASE);
  EXPECT_EQ(watch.phase(now), Phase::READY) << "what it said long ago does not count";
}

TEST(Outcome, has_the_name_of_its_constant_and_status_counts_where_they_contradict)
{
  EXPECT_EQ(nameOfOutcome(0), "SUCCESS (0)");
  EXPECT_EQ(nameOfOutcome(15), "GOAL_BLOCKED (15)");
  EXPECT_EQ(nameOfOutcome(53), "INVALID_GOAL (53)");
  EXPECT_EQ(nameOfOutcome(106), "ROBOT_STUCK (106)");
  EXPECT_EQ(nameOfOutcome(158), "IMPASSABLE (158)");
  EXPECT_EQ(nameOfOutcome(80), "a planner's own outcome (80)");
  EXPECT_EQ(nameOfOutcome(130), "a controller's own outcome (130)");
  EXPECT_EQ(nameOfOutcome(4000000000u), "an outcome that has no name (4000000000)");
  // As actionlib answers a goal that is canceled before its start.
  const Outcome recalled = outcomeOf(GoalStatus::RECALLED, "recalled", 0, "");
  EXPECT_FALSE(recalled.succeeded);
  EXPECT_EQ(recalled.text(), "CANCELED: recalled");
  const Outcome odd = outcomeOf(GoalStatus::ABORTED, "", 54, "two\nlines" + std::string(5000, 'x'));
  EXPECT_EQ(odd.message.find('\n'), std::string::npos);
  EXPECT_LE(odd.message.size(), 2100u);
}

TEST(RemainingPath, a_path_that_crosses_itself_is_followed_in_its_order)
{
  // A loop: along x, up, back, and down across the beginning.
  RemainingPath path;
  path.setPath("map", {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {5, 10, 0}, {5, -10, 0}});
  ServerWatch::Time now{seconds(1)};
  path.takePosition("map", {5, 0, 0}, now);
  EXPECT_NEAR(path.length().value_or(-1), 5 + 10 + 5 + 20, 1e-9);
  for (double y = 0; y <= 10; y += 1) {
    path.takePosition("map", {10, y, 0}, now += seconds(1));
  }
  path.takePosition("map", {7, 10, 0}, now += seconds(1));
  for (double y = 9; y >= 0; y -= 1) {
    path.takePosition("map", {5, y, 0}, now += seconds(1));
  }
  EXPECT_NEAR(path.length().value_or(-1), 10, 1e-9) << "the second time that it comes here";
  path.takePosition("odom", {5, 0, 0}, now);
  EXPECT_FALSE(path.length()) << "another frame";
  path.takePosition("map", {std::numeric_limits<double>::quiet_NaN(), 0, 0}, now);
  EXPECT_FALSE(path.length());
}

TEST(RemainingPath, a_robot_that_stands_has_no_time)
{
  RemainingPath path;
  ServerWatch::Time now{seconds(1)};
  EXPECT_FALSE(path.timeFor(3));
  path.takePosition("map", {0, 0, 0}, now);
  path.takePosition("map", {0, 0, 0}, now + seconds(5));
  EXPECT_FALSE(path.timeFor(3));
  path.setPath("map", {});
  EXPECT_FALSE(path.length());
  path.setPath("map", {{1, 0, 0}});
  EXPECT_NEAR(path.length().value_or(-1), 1, 1e-9);
}

}  // namespace
