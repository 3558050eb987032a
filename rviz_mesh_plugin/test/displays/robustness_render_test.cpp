#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rviz/display_group.h>
#include <rviz/visualization_manager.h>
#include <tf2_ros/transform_broadcaster.h>

#include "support/display_fixture.h"

namespace {

mesh_msgs::MeshGeometryStamped grid(std::uint32_t cells)
{
  return test_meshes::terrain(cells, [](double x, double y) { return 0.1 * x * y; });
}

std::vector<float> ramp(std::size_t count)
{
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = static_cast<float>(i);
  }
  return values;
}

std::string sizes(std::uint32_t cells)
{
  return std::to_string((cells + 1) * (cells + 1)) + " vertices, " +
         std::to_string(2 * cells * cells) + " faces";
}

}  // namespace

class RobustnessTest : public DisplayFixture
{
 protected:
  /// What is shared by all meshes exists before anything is counted.
  void SetUp() override
  {
    DisplayFixture::SetUp();
    delete displayWithEverything();
    geometry.shutdown();
    costs.shutdown();
    geometry = node.advertise<mesh_msgs::MeshGeometryStamped>(geometry_topic, 100, true);
    costs = node.advertise<mesh_msgs::MeshVertexCostsStamped>(costs_topic, 100, true);
    spinFrames();
    empty = counts();
  }

  /// Faces by costs, wireframe, normals.
  Display* displayWithEverything(std::uint32_t cells = 4)
  {
    auto* display = createMeshDisplay();
    set(display, {"Show Wireframe"}, true);
    set(display, {"Show Normals"}, true);
    set(display, {"Display Type"}, "Vertex Costs");
    set(display, {"Display Type", "Vertex Costs Type"}, "a");
    publish(cells);
    EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", sizes(cells)));
    EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'"));
    settle();
    return display;
  }

  void publish(std::uint32_t cells)
  {
    geometry.publish(grid(cells));
    costs.publish(test_meshes::costs("a", ramp((cells + 1) * (cells + 1))));
  }

  /// Waits until the scene has been the same for a while: uploads are done.
  static void settle()
  {
    auto last = counts();
    for (int same = 0, i = 0; same < 3 && i < 100; ++i) {
      spinFrames();
      const auto now = counts();
      same = now == last ? same + 1 : 0;
      last = now;
    }
  }

  osmesa_harness::SceneCounts empty;
};

TEST_F(RobustnessTest, a_hundred_messages_at_50_hz_of_changing_sizes_leave_nothing_behind)
{
  auto* display = displayWithEverything(10);
  const auto before = counts();
  for (int i = 0; i < 100; ++i) {
    publish(i % 2 ? 3 : 60 + i % 5);
    spin(20);
  }
  publish(10);
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", sizes(10)));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 121 costs from 0 to 120"));
  settle();
  EXPECT_EQ(counts(), before);
  delete display;
  spinFrames();
  EXPECT_EQ(counts(), empty);
}

TEST_F(RobustnessTest, a_thousand_times_disabled_enabled_and_reset)
{
  auto* display = displayWithEverything();
  const auto shown = counts();
  for (int i = 0; i < 1000; ++i) {
    switch (i % 4) {
      case 0:
        display->setEnabled(false);
        break;
      case 1:
        display->setEnabled(true);
        break;
      case 2:
        display->reset();
        break;
      default:
        manager()->resetTime();
    }
    if (i % 50 == 0) {
      spin(30);
    }
  }
  display->setEnabled(true);
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", sizes(4)));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'"));
  settle();
  EXPECT_EQ(counts(), shown);
  delete display;
  spinFrames();
  EXPECT_EQ(counts(), empty);
}

TEST_F(RobustnessTest, two_displays_of_one_topic_do_not_meet)
{
  auto* first = displayWithEverything();
  const auto one = counts();
  auto* second = displayWithEverything();
  EXPECT_GT(counts().nodes, one.nodes);
  set(first, {"Display Type"}, "Fixed Color");
  set(first, {"Display Type", "Faces Color"}, QColor(0, 0, 255));
  set(second, {"Display Type"}, "Hide Faces");
  set(first, {"Show Wireframe"}, false);
  set(second, {"Show Wireframe"}, false);
  set(first, {"Show Normals"}, false);
  set(second, {"Show Normals"}, false);
  const auto is_blue = [](const osmesa_harness::Image& image) {
    const auto pixel = image.center();
    return pixel.blue > 150 && pixel.red < 20;
  };
  EXPECT_TRUE(is_blue(grab()));
  delete second;
  EXPECT_TRUE(is_blue(grab()));
  publish(6);
  EXPECT_TRUE(waitForStatus(first, "Geometry", "Ok", sizes(6)));
  delete first;
  spinFrames();
  EXPECT_EQ(counts(), empty);
}

TEST_F(RobustnessTest, removal_while_a_large_mesh_loads)
{
  const auto message = boost::make_shared<mesh_msgs::MeshGeometryStamped>(grid(300));
  const auto layer = test_meshes::costs("a", ramp(301 * 301));
  for (int i = 0; i < 12; ++i) {
    auto* display = createMeshDisplay();
    set(display, {"Display Type"}, "Vertex Costs");
    set(display, {"Display Type", "Vertex Costs Type"}, "a");
    geometry.publish(message);
    costs.publish(layer);
    spin(25 * i);
    if (i % 3 == 0) {
      display->setEnabled(false);
      display->setEnabled(true);
    } else if (i % 3 == 1) {
      display->reset();
      spin(5);
    }
    delete display;
  }
  spinFrames();
  EXPECT_EQ(counts(), empty);
}

TEST_F(RobustnessTest, changes_of_every_kind_while_a_large_mesh_loads)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  const char* const types[] = {"Fixed Color", "Vertex Color", "Textures", "Vertex Costs",
                               "Hide Faces"};
  for (int i = 0; i < 40; ++i) {
    publish(i % 2 ? 250 : 20);
    set(display, {"Display Type"}, types[i % 5]);
    set(display, {"Show Normals"}, i % 3 == 0);
    set(display, {"Show Wireframe"}, i % 4 == 0);
    set(display, {"Display Type", "Color Scale"}, i % 2 ? "Rainbow" : "Red Green");
    if (i % 7 == 3) {
      set(display, {"Geometry Topic"}, "/nobody/publishes/this");
      spin(10);
      set(display, {"Geometry Topic"}, geometry_topic.c_str());
    }
    spin(15);
  }
  set(display, {"Display Type"}, "Vertex Costs");
  publish(20);
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", sizes(20)));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 441 costs"));
  delete display;
  spinFrames();
  EXPECT_EQ(counts(), empty);
}

TEST_F(RobustnessTest, flips_of_the_fixed_frame_while_messages_come)
{
  tf2_ros::TransformBroadcaster broadcaster;
  const auto sendTransform = [&broadcaster](double x) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = ros::Time::now();
    transform.header.frame_id = "odom";
    transform.child_frame_id = "map";
    transform.transform.translation.x = x;
    transform.transform.rotation.w = 1.0;
    broadcaster.sendTransform(transform);
  };
  auto* display = displayWithEverything();
  const auto shown = counts();
  for (int i = 0; i < 60; ++i) {
    sendTransform(0.1 * (i % 7));
    manager()->setFixedFrame(i % 3 == 0 ? "odom" : i % 3 == 1 ? "nowhere" : "map");
    if (i % 5 == 0) {
      publish(2 + i % 4);
    }
    spin(15);
  }
  publish(4);
  manager()->setFixedFrame("nowhere");
  EXPECT_TRUE(waitForStatus(display, "Transform", "Error", "nowhere"));
  manager()->setFixedFrame("odom");
  sendTransform(1.0);
  EXPECT_TRUE(waitForStatus(display, "Transform", "Ok", "odom"));
  manager()->setFixedFrame("map");
  EXPECT_TRUE(waitForStatus(display, "Transform", "Ok", "map"));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", sizes(4)));
  settle();
  EXPECT_EQ(counts(), shown);
}

TEST_F(RobustnessTest, a_configuration_loaded_again_and_again)
{
  auto* display = displayWithEverything();
  rviz::Config config;
  manager()->getRootDisplayGroup()->save(config);
  delete display;
  for (int i = 0; i < 20; ++i) {
    manager()->getRootDisplayGroup()->load(config);
    spin(i % 4 * 10);
  }
  ASSERT_EQ(manager()->getRootDisplayGroup()->numDisplays(), 1);
  display = dynamic_cast<Display*>(manager()->getRootDisplayGroup()->getDisplayAt(0));
  ASSERT_TRUE(display);
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", sizes(4)));
  manager()->removeAllDisplays();
  spinFrames();
  EXPECT_EQ(counts(), empty);
}
