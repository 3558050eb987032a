#include <memory>
#include <set>
#include <string>
#include <vector>

#include <mbf_msgs/MoveBaseGoal.h>
#include <ros/master.h>
#include <ros/serialization.h>
#include <ros/this_node.h>
#include <roscpp/GetLoggers.h>
#include <rviz/config.h>
#include <rviz/visualization_manager.h>
#include <std_srvs/Empty.h>
#include <QComboBox>
#include <QCoreApplication>
#include <QLabel>
#include <QLineEdit>
#include <QMainWindow>
#include <QPushButton>
#include <QRegularExpression>
#include <QWheelEvent>

#include "navigation/diagnostic_array.h"
#include "panel/mesh_navigation_panel.h"
#include "support/fake_navigation_server.h"
#include "support/kept_picture.h"
#include "support/service_servers.h"
#include "support/status_fixture.h"

using rviz_mesh_plugin::MeshNavigationPanel;
using service_servers::Gate;
using service_servers::Servers;
using Status = actionlib_msgs::GoalStatus;

namespace {

constexpr int GOOD = Status::SUCCEEDED, BAD = Status::ABORTED, PREEMPTED = Status::PREEMPTED;

}  // namespace

class MeshNavigationPanelTest : public StatusFixture
{
 protected:
  void SetUp() override
  {
    StatusFixture::SetUp();
    name = "/" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name());
    window = std::make_unique<QMainWindow>();
    panel = new MeshNavigationPanel;
    window->setCentralWidget(panel);
    window->resize(340, 460);
    panel->initialize(manager());
    window->show();
  }

  void TearDown() override
  {
    window.reset();
    StatusFixture::TearDown();
  }

  /// A server, whose topics the panel listens to.
  void start()
  {
    server = std::make_unique<FakeNavigationServer>(name);
    choose("server", name);
    ASSERT_TRUE(spinUntil([this] { return server->isWatched(); }, TIMEOUT));
    ASSERT_TRUE(waitFor("phase", "Ready"));
  }

  QComboBox* box(const std::string& what)
  {
    const auto boxes = panel->findChildren<QComboBox*>();
    return boxes.at(what == "server" ? 0 : what == "planner" ? 1 : 2);
  }

  /// As somebody types it, and presses Enter.
  void choose(const std::string& what, const std::string& text)
  {
    box(what)->setEditText(QString::fromStdString(text));
    Q_EMIT box(what)->lineEdit()->editingFinished();
  }

  QPushButton* button(const char* text)
  {
    for (auto* button : panel->findChildren<QPushButton*>()) {
      if (button->text() == text) {
        return button;
      }
    }
    return nullptr;
  }

  /// Without the markup.
  std::string line(const char* label) const
  {
    QString text = panel->findChild<QLabel*>(label)->text();
    return text.remove(QRegularExpression("<[^>]*>"))
        .replace("&quot;", "\"")
        .replace("&#39;", "'")
        .toStdString();
  }

  testing::AssertionResult waitFor(const char* label, const std::string& text)
  {
    if (spinUntil([&] { return line(label).find(text) != std::string::npos; }, TIMEOUT)) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure()
           << label << ": waited for '" << text << "', there is '" << line(label) << "'; phase "
           << line("phase") << ": " << line("reason");
  }

  std::set<std::string> canceled() const
  {
    return {server->canceled.begin(), server->canceled.end()};
  }

  std::string name;
  ros::NodeHandle node;
  std::unique_ptr<QMainWindow> window;
  MeshNavigationPanel* panel = nullptr;
  std::unique_ptr<FakeNavigationServer> server;
};

TEST_F(MeshNavigationPanelTest, no_server_one_that_comes_and_one_that_goes)
{
  EXPECT_TRUE(waitFor("phase", "No server"));
  EXPECT_TRUE(waitFor("reason", "There is no action server /move_base_flex/move_base: start one"));
  EXPECT_FALSE(button("Cancel")->isEnabled());
  EXPECT_FALSE(button("Clear Layers")->isEnabled());
  keep(window.get(), "navigation_no_server");
  // The only one there is, whatever its name.
  server = std::make_unique<FakeNavigationServer>(name);
  EXPECT_TRUE(waitFor("phase", "Ready"));
  ASSERT_TRUE(panel->server());
  EXPECT_EQ(panel->server()->watch().server(), name);
  EXPECT_GE(box("server")->findText(QString::fromStdString(name)), 0);
  server.reset();
  EXPECT_TRUE(waitFor("phase", "No server"));
  EXPECT_TRUE(waitFor("reason", "is gone"));
  server = std::make_unique<FakeNavigationServer>(name);
  EXPECT_TRUE(waitFor("phase", "Ready"));
}

TEST_F(MeshNavigationPanelTest, a_blocked_goal_its_recovery_and_its_reason)
{
  start();
  const auto goal = server->sendGoal("goal", 3.0);
  EXPECT_TRUE(waitFor("phase", "Planning"));
  EXPECT_TRUE(waitFor("goal", "(3.00, 0.00, 0.00) m in 'map'"));
  EXPECT_TRUE(button("Cancel")->isEnabled());
  server->failPlan(53, "the goal is on ground that <steepness> calls lethal");
  server->recover("back_up");
  EXPECT_TRUE(waitFor("phase", "Recovering"));
  EXPECT_TRUE(waitFor("reason", "With 'back_up', since planning failed, INVALID_GOAL (53)"));
  server->forget("recovery");
  server->end(goal, BAD, 53, "the goal is on ground that <steepness> calls lethal; 40 deg > 30");
  EXPECT_TRUE(waitFor("phase", "Ready"));
  EXPECT_TRUE(waitFor("outcome", "INVALID_GOAL (53): the goal is on ground that"));
  // What a server says is no markup.
  EXPECT_TRUE(panel->findChild<QLabel*>("outcome")->text().contains("&lt;steepness&gt;"));
  keep(window.get(), "navigation_blocked");
}

TEST_F(MeshNavigationPanelTest, a_drive_and_what_remains_of_it)
{
  start();
  const auto goal = server->sendGoal("goal", 8.0);
  server->drive(0.0, 8.0);
  EXPECT_TRUE(waitFor("phase", "Driving"));
  double x = 0.0;
  ASSERT_TRUE(spinUntil(
      [&] {
        server->at(goal, x += 0.01);
        return line("remaining").find(" s") != std::string::npos;
      },
      TIMEOUT))
      << line("remaining");
  EXPECT_TRUE(waitFor("remaining", "m along the path, about"));
  keep(window.get(), "navigation_driving");
  button("Cancel")->click();
  EXPECT_TRUE(waitFor("report", "Cancel was sent."));
  ASSERT_TRUE(spinUntil([&] { return !server->canceled.empty(); }, TIMEOUT));
  // A drive that somebody else has begun beside it would go on otherwise.
  EXPECT_TRUE(spinUntil([&] { return canceled().size() == 4; }, TIMEOUT)) << canceled().size();
  server->forget("exe_path");
  server->end(goal, PREEMPTED, 11, "canceled by a client");
  EXPECT_TRUE(waitFor("outcome", "CANCELED (11): canceled by a client"));
  EXPECT_EQ(line("remaining"), "");
  // A drive of somebody else's.
  server->canceled.clear();
  server->drive(0.0, 1.0);
  EXPECT_TRUE(waitFor("phase", "Driving"));
  EXPECT_EQ(line("report"), "") << "that was the goal before";
  button("Cancel")->click();
  EXPECT_TRUE(spinUntil([&] { return canceled().count("exe_path") == 1; }, TIMEOUT));
}

TEST_F(MeshNavigationPanelTest, what_is_not_known_to_be_busy_can_be_canceled)
{
  start();
  // It may have begun since its last status.
  ASSERT_TRUE(spinUntil([&] { return button("Cancel")->isEnabled(); }, TIMEOUT));
  button("Cancel")->click();
  EXPECT_TRUE(spinUntil([&] { return canceled().size() == 4; }, TIMEOUT));
  EXPECT_EQ(line("report"), "Cancel was sent.");
  server->sendGoal("goal", 3.0);
  EXPECT_TRUE(waitFor("goal", "(3.00"));
  EXPECT_EQ(line("report"), "") << "of another goal";
}

TEST_F(MeshNavigationPanelTest, another_server_is_never_chosen_by_itself)
{
  server = std::make_unique<FakeNavigationServer>("/zzz" + name);
  ASSERT_TRUE(waitFor("phase", "Ready"));
  ASSERT_EQ(panel->server()->watch().server(), "/zzz" + name);
  choose("planner", "mine");
  // One that sorts before it, and one of the usual name.
  std::size_t told = 0;
  const FakeNavigationServer other("/aaa" + name), usual("/move_base_flex");
  const auto bridge = node.subscribe<mbf_msgs::MoveBaseGoal>(
      "/aaa" + name + "/goal_defaults", 5,
      [&](const mbf_msgs::MoveBaseGoal::ConstPtr&) { ++told; });
  ASSERT_TRUE(spinUntil([&] { return box("server")->count() == 3; }, TIMEOUT));
  spinFrames(5);
  EXPECT_EQ(panel->server()->watch().server(), "/zzz" + name);
  EXPECT_EQ(box("server")->lineEdit()->placeholderText().toStdString(), "/zzz" + name);
  server.reset();
  EXPECT_TRUE(waitFor("reason", "is gone"));
  EXPECT_EQ(panel->server()->watch().server(), "/zzz" + name);
  EXPECT_EQ(told, 0u);
}

TEST_F(MeshNavigationPanelTest, of_several_servers_the_user_chooses)
{
  server = std::make_unique<FakeNavigationServer>("/b" + name);
  const FakeNavigationServer other("/a" + name);
  choose("server", "/b" + name);
  ASSERT_TRUE(spinUntil([&] { return box("server")->count() == 2; }, TIMEOUT));
  choose("server", "");
  EXPECT_TRUE(waitFor("reason", "There are 2 navigation servers: choose one above"));
  EXPECT_FALSE(panel->server());
  EXPECT_FALSE(button("Cancel")->isEnabled());
  keep(window.get(), "navigation_several");
}

TEST_F(MeshNavigationPanelTest, the_wheel_changes_no_choice_and_lists_take_nothing_away)
{
  start();
  ASSERT_TRUE(spinUntil([&] { return box("server")->count() == 1; }, TIMEOUT));
  box("planner")->addItems({"a", "b"});
  box("planner")->setCurrentIndex(0);
  QWheelEvent wheel({5, 5}, {5, 5}, {0, -120}, {0, -120}, Qt::NoButton, Qt::NoModifier,
                    Qt::NoScrollPhase, false);
  QCoreApplication::sendEvent(box("planner"), &wheel);
  EXPECT_EQ(box("planner")->currentText(), "a");
  // What is being typed stays that, when the list changes.
  box("server")->lineEdit()->setModified(true);
  const FakeNavigationServer other(name + "_2");
  ASSERT_TRUE(spinUntil([&] { return box("server")->count() == 2; }, TIMEOUT));
  EXPECT_TRUE(box("server")->lineEdit()->isModified());
}

TEST_F(MeshNavigationPanelTest, of_two_goals_each_has_its_outcome)
{
  start();
  const auto first = server->sendGoal("first", 1.0);
  EXPECT_TRUE(waitFor("goal", "(1.00"));
  const auto second = server->sendGoal("second", 2.0);
  server->end(first, PREEMPTED, 11, "a newer goal took slot 0");
  EXPECT_TRUE(waitFor("goal", "(2.00"));
  EXPECT_TRUE(waitFor("before", "The goal before: CANCELED (11): a newer goal took slot 0"));
  EXPECT_EQ(line("outcome"), "");
  server->end(second, GOOD, 0, "there");
  EXPECT_TRUE(waitFor("outcome", "SUCCESS (0): there"));
}

TEST_F(MeshNavigationPanelTest, a_server_that_hangs_with_a_robot_on_its_path)
{
  Servers services;
  Gate gate;
  const auto hangs = services.serve<roscpp::GetLoggers>(
      name + "/get_loggers", [&](roscpp::GetLoggers::Request&, roscpp::GetLoggers::Response&) {
        gate.pass();
        return true;
      });
  start();
  const auto goal = server->sendGoal("goal", 3.0);
  server->drive(0, 3);
  EXPECT_TRUE(waitFor("phase", "Driving"));
  server->alive = false;
  EXPECT_TRUE(waitFor("phase", "Not answering"));
  EXPECT_TRUE(waitFor("reason", "is there and does not answer"));
  EXPECT_TRUE(waitFor("reason", "what the robot does now is not known"));
  EXPECT_TRUE(waitFor("outcome", "not known: the server says nothing any more"));
  EXPECT_GE(gate.reached, 1) << "it was asked";
  EXPECT_TRUE(button("Cancel")->isEnabled()) << "it may hear that still";
  keep(window.get(), "navigation_hangs");
  server->alive = true;
  EXPECT_TRUE(waitFor("phase", "Driving"));
  server->forget("exe_path");
  server->end(goal, GOOD, 0, "there");
  EXPECT_TRUE(waitFor("outcome", "SUCCESS (0): there"));
}

TEST_F(MeshNavigationPanelTest, a_server_that_cannot_be_reached_is_not_said_to_be_gone)
{
  start();
  // Where its process is cannot be asked from here.
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = "/out_of_reach";  // not this node: roscore would forget all else of it
  request[1] = name + "/get_loggers";
  request[2] = "rosrpc://host.invalid:1";
  request[3] = "http://host.invalid:1";
  ASSERT_TRUE(ros::master::execute("registerService", request, response, payload, false));
  server->alive = false;
  EXPECT_TRUE(waitFor("phase", "Not answering"));
  EXPECT_TRUE(waitFor("reason", "cannot be reached"));
  EXPECT_EQ(line("reason").find("start it again"), std::string::npos) << line("reason");
}

TEST_F(MeshNavigationPanelTest, why_a_server_is_not_ready)
{
  start();
  ros::AdvertiseOptions options(
      "/diagnostics", 5, ros::message_traits::md5sum<rviz_mesh_plugin::DiagnosticArray>(),
      ros::message_traits::datatype<rviz_mesh_plugin::DiagnosticArray>(), "");
  ros::Publisher diagnostics = node.advertise(options);
  rviz_mesh_plugin::DiagnosticArray message;
  message.status.resize(2);
  message.status[0].name = "another: navigation";
  message.status[0].message = "of no interest";
  message.status[1].name = name.substr(1) + ": navigation";
  message.status[1].level = 1;
  message.status[1].message = "the map is still being loaded, for 12 s now";
  message.status[1].values.push_back({"ready", "False"});
  ASSERT_TRUE(spinUntil(
      [&] {
        diagnostics.publish(message);
        return line("phase") == "Not ready";
      },
      TIMEOUT));
  EXPECT_TRUE(waitFor("reason", "Goals wait or are refused: the map is still being loaded"));
  keep(window.get(), "navigation_not_ready");
}

TEST_F(MeshNavigationPanelTest, planner_and_controller_are_told_to_those_who_send_goals)
{
  XmlRpc::XmlRpcValue planners;
  planners[0]["name"] = "wave_front_planner";
  planners[0]["type"] = "x";
  planners[1] = "no plugin at all";
  planners[2]["name"] = "";
  planners[3]["type"] = "without a name";
  planners[4]["name"] = "dijkstra_mesh_planner";
  planners[5]["name"] = "dijkstra_mesh_planner";
  node.setParam(name + "/planners", planners);
  node.setParam(name + "/controllers", "not even a list");
  start();
  ASSERT_TRUE(spinUntil([&] { return box("planner")->count() == 2; }, TIMEOUT));
  EXPECT_EQ(box("planner")->itemText(0), "wave_front_planner");
  EXPECT_EQ(box("planner")->itemText(1), "dijkstra_mesh_planner");
  EXPECT_EQ(box("controller")->count(), 0) << "and yet one can be typed";
  EXPECT_EQ(line("choice"), "");

  choose("planner", "dijkstra_mesh_planner");
  EXPECT_TRUE(waitFor("choice", "Nobody takes this choice"));
  keep(window.get(), "navigation_choice");
  std::vector<mbf_msgs::MoveBaseGoal> told;
  const auto bridge = node.subscribe<mbf_msgs::MoveBaseGoal>(
      name + "/goal_defaults", 5,
      [&](const mbf_msgs::MoveBaseGoal::ConstPtr& message) { told.push_back(*message); });
  ASSERT_TRUE(spinUntil([&] { return !told.empty(); }, TIMEOUT)) << "who comes later";
  EXPECT_EQ(told.back().planner, "dijkstra_mesh_planner");
  EXPECT_EQ(told.back().controller, "");
  EXPECT_TRUE(spinUntil([&] { return line("choice").empty(); }, TIMEOUT)) << line("choice");
  choose("controller", "my_controller");
  ASSERT_TRUE(spinUntil([&] { return told.size() == 2; }, TIMEOUT));
  EXPECT_EQ(told.back().controller, "my_controller");
  choose("planner", "typo");
  EXPECT_TRUE(waitFor("choice", "The server has no planner 'typo'"));
}

TEST_F(MeshNavigationPanelTest, nothing_is_told_where_nothing_was_chosen)
{
  std::size_t told = 0;
  const auto bridge = node.subscribe<mbf_msgs::MoveBaseGoal>(
      name + "/goal_defaults", 5, [&](const mbf_msgs::MoveBaseGoal::ConstPtr&) { ++told; });
  start();
  choose("planner", "");
  ASSERT_TRUE(spinUntil([&] { return bridge.getNumPublishers() == 1; }, TIMEOUT));
  choose("planner", "last");
  ASSERT_TRUE(spinUntil([&] { return told > 0; }, TIMEOUT));
  EXPECT_EQ(told, 1u);
}

TEST_F(MeshNavigationPanelTest, the_servers_first_can_be_chosen_over_what_another_has)
{
  std::vector<mbf_msgs::MoveBaseGoal> told;
  const auto bridge = node.subscribe<mbf_msgs::MoveBaseGoal>(
      name + "/goal_defaults", 5,
      [&](const mbf_msgs::MoveBaseGoal::ConstPtr& message) { told.push_back(*message); });
  start();
  ASSERT_TRUE(spinUntil([&] { return bridge.getNumPublishers() == 1; }, TIMEOUT));
  Q_EMIT box("planner")->lineEdit()->returnPressed();
  ASSERT_TRUE(spinUntil([&] { return told.size() == 1; }, TIMEOUT));
  EXPECT_EQ(told[0].planner, "");
  mbf_msgs::MoveBaseActionGoal goal;
  goal.goal_id = FakeNavigationServer::id("goal");
  goal.goal.planner = "of somebody else";
  ros::Publisher goals = node.advertise<mbf_msgs::MoveBaseActionGoal>(name + "/move_base/goal", 5);
  ASSERT_TRUE(spinUntil(
      [&] {
        goals.publish(goal);
        return line("goal").find("planner 'of somebody else'") != std::string::npos;
      },
      TIMEOUT))
      << line("goal");
}

TEST_F(MeshNavigationPanelTest, clears_whatever_the_server_has_and_waits_for_nobody)
{
  Servers services;
  Gate gate;
  const auto clears = services.serve<std_srvs::Empty>(
      name + "/clear_costmaps", [&](std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
        gate.pass();
        return true;
      });
  start();
  ASSERT_TRUE(spinUntil([&] { return button("Clear Layers")->isEnabled(); }, TIMEOUT));
  button("Clear Layers")->click();
  ASSERT_TRUE(spinUntil([&] { return gate.reached == 1; }, TIMEOUT));
  EXPECT_TRUE(waitFor("report", "Clearing, for 1 s.")) << "while the service holds its answer back";
  EXPECT_FALSE(button("Clear Layers")->isEnabled());
  gate.open();
  EXPECT_TRUE(waitFor("report", "Cleared by " + name + "/clear_costmaps."));
}

TEST_F(MeshNavigationPanelTest, is_saved_and_loaded)
{
  choose("server", "my_server/");
  choose("planner", "a");
  choose("controller", "b");
  rviz::Config config;
  panel->save(config);
  MeshNavigationPanel other;
  other.initialize(manager());
  other.load(config);
  const auto boxes = other.findChildren<QComboBox*>();
  EXPECT_EQ(boxes.at(0)->currentText(), "my_server/");
  EXPECT_EQ(boxes.at(1)->currentText(), "a");
  EXPECT_EQ(boxes.at(2)->currentText(), "b");
  ASSERT_TRUE(other.server());
  EXPECT_EQ(other.server()->watch().server(), "/my_server");
  MeshNavigationPanel empty;
  empty.load(rviz::Config());
  EXPECT_EQ(empty.findChildren<QComboBox*>().at(0)->currentText(), "");
}

TEST_F(MeshNavigationPanelTest, names_that_are_none)
{
  for (const char* typed : {"/", "a b", "1x", "ä", "//"}) {
    choose("server", typed);
    EXPECT_TRUE(waitFor("reason", "cannot be the name of a node")) << typed;
    EXPECT_FALSE(panel->server());
  }
  choose("server", "");
  EXPECT_TRUE(waitFor("phase", "No server"));
  EXPECT_TRUE(panel->server());
}
