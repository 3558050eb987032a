#include <cmath>
#include <string>

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <rviz/config.h>
#include <rviz/tool_manager.h>
#include <std_msgs/ColorRGBA.h>

#include "surface_tool_fixture.h"
#include "tools/surface_pose_tool.h"

using rviz_mesh_plugin::MeshGoalTool;
using rviz_mesh_plugin::MeshPoseEstimateTool;

namespace {

constexpr int FINISHED = rviz::Tool::Render | rviz::Tool::Finished;

}  // namespace

class PoseToolTest : public SurfaceToolFixture<MeshGoalTool, geometry_msgs::PoseStamped>
{
 protected:
  /// Seen aslant from above.
  void showFlat()
  {
    showSquare({}, "flat");
    look({{-2, -4, 3}, {0.3, 0, 0.2}});
  }
};

TEST_F(PoseToolTest, topics_can_be_changed_and_bad_ones_are_told)
{
  showFlat();
  const auto click = [&] {
    press(325, 240);
    EXPECT_EQ(release(325, 240), FINISHED);
  };
  for (const char* bad : {"", "a b", "~goal", "//", "1goal"}) {
    set({"Topic"}, bad);
    click();
    EXPECT_TRUE(says("was not published")) << bad << ": " << said;
  }
  set({"Topic"}, (topic + "/other").c_str());
  click();
  EXPECT_TRUE(says("/other, but nobody receives it")) << said;
  listen(topic + "/other");
  ASSERT_TRUE(spinUntil([&] { return subscriber.getNumPublishers() == 1; }));
  click();
  next();
  const auto other = node.advertise<std_msgs::ColorRGBA>(topic + "/color", 1);
  set({"Topic"}, (topic + "/color").c_str());
  click();
  EXPECT_TRUE(says("of another type")) << said;

  rviz::Config config;
  tool->save(config);
  MeshGoalTool loaded;
  loaded.load(config);
  EXPECT_EQ(loaded.getPropertyContainer()->subProp("Topic")->getValue().toString().toStdString(),
            topic + "/color");
  EXPECT_EQ(loaded.getShortcutKey(), 'm');
}

TEST_F(PoseToolTest, shows_an_arrow_until_it_is_left)
{
  showFlat();
  EXPECT_EQ(countColored(grab(), 1), 0u);
  set({"Arrow Length"}, 1.25);
  press(260, 260);
  move(400, 200);
  const auto picture = grab();
  picture.save(osmesa_harness::resultsFolder() + "/mesh_goal_arrow.png");
  const std::size_t seen = countColored(picture, 1);
  EXPECT_GT(seen, 500u);
  set({"Arrow Length"}, 2.5);
  move(400, 201);
  const auto larger = grab();
  larger.save(osmesa_harness::resultsFolder() + "/mesh_goal_arrow_2.png");
  EXPECT_GT(countColored(larger, 1), 2 * seen);
  release(400, 200);
  tool->deactivate();
  EXPECT_EQ(countColored(grab(), 1), 0u);
  const auto before = counts();
  {
    MeshGoalTool other;
    other.initialize(manager());
    EXPECT_GT(counts().nodes, before.nodes);
  }
  EXPECT_EQ(counts().nodes, before.nodes);
  EXPECT_EQ(counts().materials, before.materials);
}

TEST_F(PoseToolTest, works_as_the_current_tool_of_rviz)
{
  showFlat();
  rviz::ToolManager* const tools = manager()->getToolManager();
  rviz::Tool* const before = tools->getCurrentTool();
  const auto send = [](int x, int y, QEvent::Type type) {
    manager()->handleMouseEvent(mouse(x, y, type, Qt::LeftButton));
  };
  tools->setCurrentTool(tool.get());
  send(260, 260, QEvent::MouseButtonPress);
  QKeyEvent escape(QEvent::KeyPress, Qt::Key_Escape, Qt::NoModifier);
  tools->handleChar(&escape, panel());
  EXPECT_EQ(tools->getCurrentTool(), tools->getDefaultTool());
  EXPECT_TRUE(says("given up")) << said;
  tools->setCurrentTool(tool.get());
  send(260, 260, QEvent::MouseButtonPress);
  send(400, 200, QEvent::MouseMove);
  EXPECT_EQ(tools->getCurrentTool(), tool.get());
  EXPECT_GT(countColored(grab(), 1), 500u);
  send(400, 200, QEvent::MouseButtonRelease);
  EXPECT_EQ(tools->getCurrentTool(), tools->getDefaultTool());
  next();
  EXPECT_EQ(countColored(grab(), 1), 0u);
  EXPECT_TRUE(received.empty());
  tools->setCurrentTool(before);
}

class MeshPoseEstimateTest
    : public SurfaceToolFixture<MeshPoseEstimateTool, geometry_msgs::PoseWithCovarianceStamped>
{
};

TEST_F(MeshPoseEstimateTest, publishes_the_pose_and_its_covariance)
{
  showSquare({{0, 0, 0.5}, {1, 0, 0, 0}}, "flat");
  viewFromAbove();
  spinFrames();
  EXPECT_EQ(tool->getShortcutKey(), 'e');
  press(320, 240);
  EXPECT_GT(countColored(grab(), 0), 100u);
  EXPECT_EQ(release(320, 140), FINISHED);
  auto message = next();
  EXPECT_EQ(message.header.frame_id, "map");
  const auto& pose = message.pose.pose;
  EXPECT_NEAR(pose.position.x, 0.005, 1e-5);
  EXPECT_NEAR(pose.position.y, -0.005, 1e-5);
  EXPECT_NEAR(pose.position.z, 0.5, 1e-5);
  EXPECT_NEAR(pose.orientation.z, std::sqrt(0.5), 1e-5);
  EXPECT_NEAR(pose.orientation.w, std::sqrt(0.5), 1e-5);
  const double diagonal[] = {0.25, 0.25, 0.01, 0.01, 0.01, M_PI * M_PI / 144};
  for (unsigned i = 0; i < 36; ++i) {
    EXPECT_NEAR(message.pose.covariance[i], i % 7 == 0 ? diagonal[i / 7] : 0.0, 1e-7) << i;
  }
  set({"Covariance yaw"}, 2.0);
  set({"Covariance x"}, -3.0);
  press(320, 240);
  release(320, 140);
  message = next();
  EXPECT_EQ(message.pose.covariance[35], 2.0);
  EXPECT_EQ(message.pose.covariance[0], 0.0);
}
