#include <memory>
#include <string>

#include <geometry_msgs/PoseStamped.h>
#include <rviz/tool_manager.h>

#include "support/fake_navigation_server.h"
#include "surface_tool_fixture.h"
#include "tools/surface_pose_tool.h"

using rviz_mesh_plugin::MeshGoalTool;

/// What becomes of a goal, as the status bar tells it.
class GoalOutcomeTest : public SurfaceToolFixture<MeshGoalTool, geometry_msgs::PoseStamped>
{
 protected:
  using Status = actionlib_msgs::GoalStatus;

  void SetUp() override
  {
    SurfaceToolFixture::SetUp();
    server = std::make_unique<FakeNavigationServer>(
        "/" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    showSquare({}, "flat");
    look({{-3, 0, 2}, {0, 0, 0}});
    ASSERT_TRUE(spinUntil([&] { return server->isWatched(); }, TIMEOUT));
  }

  void TearDown() override
  {
    server.reset();
    SurfaceToolFixture::TearDown();
  }

  /// As RViz does it: the tool is left as soon as it has finished.
  geometry_msgs::PoseStamped click(int x, int y)
  {
    press(x, y);
    release(x, y);
    tool->deactivate();
    return next();
  }

  testing::AssertionResult comes(const std::string& text)
  {
    if (spinUntil([&] { return says(text); }, TIMEOUT)) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << "waited for '" << text << "', there is '" << said << "'";
  }

  std::unique_ptr<FakeNavigationServer> server;
};

TEST_F(GoalOutcomeTest, of_a_blocked_goal_the_reason_is_told)
{
  const auto pose = click(320, 240);
  const auto goal = server->sendGoal("goal", 0.0, &pose);
  EXPECT_TRUE(comes("Goal: planning"));
  server->failPlan(53, "steepness calls the goal lethal");
  server->recover("back_up");
  EXPECT_TRUE(comes("Goal: recovering; with 'back_up', since planning failed, INVALID_GOAL (53)"));
  server->forget("recovery");
  server->end(goal, Status::ABORTED, 53, "steepness calls the goal lethal");
  EXPECT_TRUE(
      comes("The goal was not reached: INVALID_GOAL (53): steepness calls the goal lethal"));
  // Other tools write over it.
  manager()->setStatus("Left-Click: Rotate.");
  EXPECT_TRUE(comes("The goal was not reached"));
}

TEST_F(GoalOutcomeTest, of_a_drive_what_remains_and_that_it_arrived)
{
  const auto pose = click(320, 240);
  const auto goal = server->sendGoal("goal", 0.0, &pose);
  server->drive(0.0, 8.0);
  server->at(goal, 0.5);
  EXPECT_TRUE(comes("Goal: driving, 7.5 m to go along the path"));
  server->forget("exe_path");
  server->end(goal, Status::SUCCEEDED, 0, "there");
  EXPECT_TRUE(comes("The goal was reached: SUCCESS (0): there"));
}

TEST_F(GoalOutcomeTest, a_goal_that_nobody_takes_and_one_of_somebody_else)
{
  click(320, 240);
  const auto other = server->sendGoal("of somebody else", 77.0);
  EXPECT_TRUE(comes("but no navigation server has got it: does goal_bridge run"));
  server->end(other, Status::SUCCEEDED, 0, "there");
  spinFrames(5);
  EXPECT_FALSE(says("reached")) << said;
}

TEST_F(GoalOutcomeTest, a_goal_of_before_or_in_another_frame_is_not_taken_for_it)
{
  geometry_msgs::PoseStamped far;
  far.header.frame_id = "elsewhere";
  const auto old = server->sendGoal("old", 0.0, &far);
  const auto newer = server->sendGoal("newer", 0.0, &far);
  spinFrames(5);
  click(320, 240);
  EXPECT_TRUE(comes("no navigation server has got it"));
  server->end(old, Status::PREEMPTED, 11, "replaced");
  server->end(newer, Status::SUCCEEDED, 0, "there");
  const auto later = server->sendGoal("later", 0.0, &far);
  server->end(later, Status::SUCCEEDED, 0, "there");
  EXPECT_FALSE(spinUntil([&] { return says("reached") || says("replaced"); }, 1000)) << said;
}

TEST_F(GoalOutcomeTest, one_that_is_passed_on_in_another_frame_is_followed)
{
  auto pose = click(320, 240);
  pose.header.frame_id = "map";
  const auto goal = server->sendGoal("goal", 0.0, &pose);
  server->end(goal, Status::SUCCEEDED, 0, "there");
  EXPECT_TRUE(comes("The goal was reached"));
}

TEST_F(GoalOutcomeTest, a_goal_whose_message_was_missed_is_followed_and_no_fault)
{
  auto pose = click(320, 240);
  // Only its status arrives: it was sent before this had connected to the server.
  auto goal = FakeNavigationServer::id("missed");
  goal.stamp = ros::Time::now();
  server->set("move_base", goal, Status::ACTIVE);
  EXPECT_TRUE(comes("Goal: planning"));
  EXPECT_FALSE(says("no navigation server"));
  server->end(goal, Status::SUCCEEDED, 0, "there");
  EXPECT_TRUE(comes("The goal was reached"));
}

TEST_F(GoalOutcomeTest, without_any_server_that_is_told)
{
  tool->deactivate();
  server.reset();
  tool = std::make_unique<MeshGoalTool>();  // one that has never seen a server
  set({"Topic"}, topic.c_str());
  tool->initialize(manager());
  tool->activate();
  ASSERT_TRUE(spinUntil([this] { return subscriber.getNumPublishers() == 1; }));
  click(320, 240);
  EXPECT_TRUE(comes("there is no navigation server: start one"));
}

TEST_F(GoalOutcomeTest, the_status_bar_of_other_tools_is_theirs)
{
  auto* tools = manager()->getToolManager();
  auto* other = tools->addTool("rviz/Measure");
  ASSERT_TRUE(other);
  tools->setCurrentTool(other);
  tools->setDefaultTool(nullptr);
  const auto pose = click(320, 240);
  const auto goal = server->sendGoal("goal", 0.0, &pose);
  server->drive(0.0, 8.0);
  server->at(goal, 0.5);
  EXPECT_FALSE(spinUntil([&] { return says("Goal: "); }, 2000)) << said;
  server->end(goal, Status::SUCCEEDED, 0, "there");
  EXPECT_TRUE(comes("The goal was reached"));
  for (int i = 0; i < 2; ++i) {  // once more, and then no more
    manager()->setStatus("of the other tool");
    EXPECT_EQ(spinUntil([&] { return says("reached"); }, 4000), i == 0);
  }
  tools->removeAll();  // the manager is that of all tests
}

TEST_F(GoalOutcomeTest, the_newest_of_two_goals_is_followed)
{
  auto pose = click(320, 240);
  const auto first = server->sendGoal("first", 0.0, &pose);
  EXPECT_TRUE(comes("Goal: planning"));
  tool->activate();
  pose = click(350, 250);
  const auto second = server->sendGoal("second", 0.0, &pose);
  server->end(first, Status::PREEMPTED, 11, "a newer goal took slot 0");
  EXPECT_TRUE(comes("Goal: planning"));
  server->end(second, Status::ABORTED, 54, "no way");
  EXPECT_TRUE(comes("The goal was not reached: NO_PATH_FOUND (54): no way"));
}

TEST_F(GoalOutcomeTest, while_a_tool_is_in_use_its_hint_stays)
{
  const auto pose = click(320, 240);
  const auto goal = server->sendGoal("goal", 0.0, &pose);
  EXPECT_TRUE(comes("Goal: planning"));
  tool->activate();
  EXPECT_TRUE(says("Press the left button")) << said;
  server->drive(0.0, 8.0);
  server->at(goal, 0.5);
  // RViz clears its status bar when the mouse leaves the picture or the window.
  manager()->setStatus("");
  EXPECT_TRUE(comes("Press the left button"));
  server->end(goal, Status::SUCCEEDED, 0, "there");
  EXPECT_TRUE(comes("The goal was reached"));
}
