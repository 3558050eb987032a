#include <algorithm>
#include <cmath>
#include <string>

#include <geometry_msgs/PoseStamped.h>

#include "surface_tool_fixture.h"
#include "tools/surface_pose_tool.h"

using rviz_mesh_plugin::MeshGoalTool;

namespace {

constexpr int FINISHED = rviz::Tool::Render | rviz::Tool::Finished;

}  // namespace

class MeshGoalTest : public SurfaceToolFixture<MeshGoalTool, geometry_msgs::PoseStamped>
{
 protected:
  /// Where a pose is, and its axes.
  struct Axes
  {
    Vector position, x, y, z;
  };

  static Axes axesOf(const geometry_msgs::Pose& pose)
  {
    const auto& q = pose.orientation;
    EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1.0, 1e-12);
    const FixedPose turned{{}, {q.w, q.x, q.y, q.z}};
    return {{pose.position.x, pose.position.y, pose.position.z},
            turned({1, 0, 0}),
            turned({0, 1, 0}),
            turned({0, 0, 1})};
  }

  /// @param error in meters, for the heading by the way of the drag
  static void expectAxes(const Axes& found, const Vector& point, const Vector& heading,
                         const Vector& normal, double error = 2e-5)
  {
    const Vector x = unit(plus(heading, -dot(heading, normal), normal));
    const double length = std::min(1.0, std::sqrt(dot(heading, heading)));
    const Vector expected[] = {point, x, cross(normal, x), normal};
    const Vector vectors[] = {found.position, found.x, found.y, found.z};
    for (unsigned i = 0; i < 12; ++i) {
      EXPECT_NEAR(vectors[i / 3][i % 3], expected[i / 3][i % 3], error / length) << i;
    }
  }

  const FixedPose tilted{{0.3, -0.2, 0.4}, {0.9, 0.25, -0.2, 0.3}};
  Vector normal() const { return minus(tilted({0, 0, 1}), tilted.position); }

  /// From the side of the normal (or the other), at so many meters above the
  /// plane at a distance.
  View viewAt(double above, double aside) const
  {
    const Vector along = minus(tilted({0.8, 0.6, 0}), tilted.position);
    return {plus(plus(tilted.position, above, normal()), -aside, along), tilted.position};
  }
};

TEST_F(MeshGoalTest, goals_on_a_tilted_plane_are_the_analytic_ones_from_everywhere)
{
  showSquare(tilted, "tilted");
  struct Case
  {
    View from;
    double error;
  };
  for (const Case& one : {Case{viewAt(2.5, 1.0), 2e-5},
                          {viewAt(-2.5, 1.0), 2e-5},     // from below
                          {viewAt(0.05, 3.0), 1e-3}}) {  // edge-on: 1 degree
    look(one.from);
    for (const char* z_axis : {"Viewer", "Up"}) {
      for (const bool switched : {false, true}) {
        SCOPED_TRACE(std::string(z_axis) + (switched ? ", switched" : "") + " from " +
                     std::to_string(view.eye[2]));
        set({"Z Axis"}, z_axis);
        set({"Switch Bottom/Top"}, switched);
        const Vector point = onPlane(325, 240, tilted.position, normal());
        const Vector cursor = onPlane(420, 252, tilted.position, normal());
        EXPECT_EQ(press(325, 240), rviz::Tool::Render) << said;
        EXPECT_EQ(move(350, 200), rviz::Tool::Render);
        EXPECT_EQ(release(420, 252), FINISHED);
        EXPECT_TRUE(says("The goal was published on " + topic)) << said;
        const auto message = next();
        EXPECT_EQ(message.header.frame_id, "map");
        EXPECT_LT(std::abs((message.header.stamp - ros::Time::now()).toSec()), 60.0);
        const bool seen = dot(minus(view.eye, point), normal()) > 0;
        const bool outside = (z_axis == std::string("Up") ? normal()[2] > 0 : seen) != switched;
        expectAxes(axesOf(message.pose), point, minus(cursor, point),
                   plus({0, 0, 0}, outside ? 1 : -1, normal()), one.error);
      }
    }
  }
}

TEST_F(MeshGoalTest, the_frame_of_the_mesh_can_be_chosen)
{
  auto* display = showSquare(tilted, "tilted");
  look(viewAt(2.5, 1.0));
  set({"Frame"}, "Mesh Frame");
  press(325, 240);
  // What becomes of the frame meanwhile does not matter.
  putFrame("tilted", {{5, 5, 5}, {1, 0, 0, 0}});
  ASSERT_TRUE(spinUntil([&] { return display->shownMeshes().at(0).position.x > 4; }));
  release(420, 252);
  const auto message = next();
  EXPECT_EQ(message.header.frame_id, "tilted");
  const Axes in_mesh = axesOf(message.pose);
  const auto turn = [&](const Vector& v) { return minus(tilted(v), tilted.position); };
  const Vector point = onPlane(325, 240, tilted.position, normal());
  const Vector cursor = onPlane(420, 252, tilted.position, normal());
  expectAxes({tilted(in_mesh.position), turn(in_mesh.x), turn(in_mesh.y), turn(in_mesh.z)}, point,
             minus(cursor, point), normal());
  EXPECT_NEAR(in_mesh.position[2], 0.0, 1e-6);
}

TEST_F(MeshGoalTest, a_frame_that_a_map_is_given_is_that_of_the_mesh)
{
  auto* display = showSquare({}, "its_own");
  rviz_mesh_plugin::MeshSource source;
  source.geometry_topic = geometry_topic;
  source.frame = "tilted";
  putFrame("tilted", tilted);
  display->setSource(source);
  ASSERT_TRUE(spinUntil([&] {
    const auto shown = display->shownMeshes();
    return shown.size() == 1 && shown[0].position.x > 0.2f;
  }));
  look(viewAt(2.5, 1.0));
  waitUntilPrepared();
  set({"Frame"}, "Mesh Frame");
  press(325, 240);
  release(325, 240);
  EXPECT_EQ(next().header.frame_id, "tilted");
}

TEST_F(MeshGoalTest, a_click_without_a_drag_looks_as_the_camera)
{
  showSquare(tilted, "tilted");
  look(viewAt(2.5, 1.0));
  press(325, 240);
  EXPECT_EQ(release(325, 240), FINISHED);
  const Vector point = onPlane(325, 240, tilted.position, normal());
  expectAxes(axesOf(next().pose), point, forward(), normal());
  // As do four pixels, wherever it has been before.
  press(325, 240);
  move(400, 100);
  release(329, 240);
  expectAxes(axesOf(next().pose), point, forward(), normal());
  // Straight from above: to the top of the picture.
  viewFromAbove(tilted.position[0], tilted.position[1]);
  putFrame("tilted", {tilted.position, {1, 0, 0, 0}});
  spinFrames();
  press(320, 240);
  release(320, 240);
  expectAxes(axesOf(next().pose), {0.305, -0.205, 0.4}, {0, 1, 0}, {0, 0, 1});
}

TEST_F(MeshGoalTest, above_the_horizon_the_last_heading_stays)
{
  showSquare({}, "flat");
  look({{-3, 0, 0.5}, {0, 0, 0.2}});
  press(320, 300);
  const Vector point = onPlane(320, 300, {0, 0, 0}, {0, 0, 1});
  ASSERT_LT(std::abs(point[0]), 1.0);
  move(350, 280);
  const Vector cursor = onPlane(350, 280, {0, 0, 0}, {0, 0, 1});
  ASSERT_GT(sight(400, 10)[2], 0.0);
  release(400, 10);
  expectAxes(axesOf(next().pose), point, minus(cursor, point), {0, 0, 1});
}

TEST_F(MeshGoalTest, right_button_and_escape_give_it_up)
{
  showSquare(tilted, "tilted");
  look(viewAt(2.5, 1.0));
  const Ogre::Vector3 before = camera()->getDerivedPosition();
  for (const int how : {0, 1, 2}) {
    press(325, 240);
    move(400, 240);
    if (how == 0) {
      EXPECT_EQ(press(400, 240, Qt::RightButton), rviz::Tool::Render);
      move(400, 300, Qt::RightButton);
      release(400, 300, Qt::RightButton);
    } else if (how == 1) {
      pressEscape();
    } else {
      tool->deactivate();  // what RViz makes of Esc
      EXPECT_TRUE(says("given up")) << said;
      tool->activate();
    }
    EXPECT_EQ(release(400, 240), 0) << how;
  }
  spinFrames();
  EXPECT_EQ(countColored(grab(), 1), 0u);
  EXPECT_EQ(camera()->getDerivedPosition(), before);
  press(325, 240);
  release(400, 240);
  next();
  spinFrames();
  EXPECT_TRUE(received.empty());
}

TEST_F(MeshGoalTest, a_release_that_went_elsewhere_gives_it_up)
{
  showSquare(tilted, "tilted");
  look(viewAt(2.5, 1.0));
  press(325, 240);
  move(400, 240);
  move(300, 300, Qt::NoButton);
  EXPECT_TRUE(says("given up")) << said;
  EXPECT_EQ(countColored(grab(), 1), 0u);
  EXPECT_EQ(release(300, 300), 0);
  press(325, 240);
  EXPECT_EQ(press(300, 300), rviz::Tool::Render) << "the second press without a release";
  EXPECT_EQ(release(300, 300), 0);
  // The second of two quick presses.
  send(325, 240, QEvent::MouseButtonDblClick);
  EXPECT_EQ(release(400, 240), FINISHED);
  next();
  spinFrames();
  EXPECT_TRUE(received.empty());
}

TEST_F(MeshGoalTest, other_buttons_and_the_wheel_move_the_camera)
{
  showSquare(tilted, "tilted");
  look(viewAt(2.5, 1.0));
  const auto moved = [&](const auto& work) {
    const Ogre::Vector3 before = camera()->getDerivedPosition();
    work();
    spinFrames();
    return (camera()->getDerivedPosition() - before).length() > 1e-3f;
  };
  Qt::MouseButtons left = Qt::NoButton;  // pressed meanwhile
  const auto drag = [&](Qt::MouseButton button) {
    press(300, 200, button);
    auto event = mouse(300, 260, QEvent::MouseMove, button);
    event.last_y = 200;
    event.buttons_down |= left;
    tool->processMouseEvent(event);
    release(300, 260, button);
  };
  const auto turnWheel = [&] {
    auto event = mouse(300, 200, QEvent::Wheel);
    event.wheel_delta = 240;
    tool->processMouseEvent(event);
  };
  EXPECT_TRUE(moved([&] { drag(Qt::RightButton); }));
  EXPECT_TRUE(moved([&] { drag(Qt::MiddleButton); }));
  EXPECT_TRUE(moved(turnWheel));
  look(viewAt(2.5, 1.0));
  const Ogre::Quaternion straight = camera()->getDerivedOrientation();
  EXPECT_TRUE(moved([&] {
    for (const auto type :
         {QEvent::MouseButtonPress, QEvent::MouseMove, QEvent::MouseButtonRelease}) {
      auto event = mouse(300, type == QEvent::MouseButtonPress ? 200 : 260, type, Qt::LeftButton);
      event.modifiers = Qt::ShiftModifier;
      event.last_y = 200;
      tool->processMouseEvent(event);
    }
  }));
  EXPECT_NE(camera()->getDerivedOrientation(), straight) << "as left alone does in Interact";
  look(viewAt(2.5, 1.0));
  press(325, 240);
  left = Qt::LeftButton;
  EXPECT_TRUE(moved(turnWheel)) << "while dragging";
  const Ogre::Quaternion turned = camera()->getDerivedOrientation();
  EXPECT_TRUE(moved([&] { drag(Qt::MiddleButton); })) << "while dragging";
  EXPECT_EQ(camera()->getDerivedOrientation(), turned) << "the left button is not the camera's";
  EXPECT_FALSE(moved([&] { move(330, 280); }));
  EXPECT_EQ(release(400, 240), FINISHED);
  next();
  look(viewAt(2.5, 1.0));
  press(325, 240);
  press(300, 200, Qt::MiddleButton);
  EXPECT_EQ(release(400, 240), FINISHED) << "while the camera is being moved";
  release(400, 240, Qt::MiddleButton);
  next();
}

TEST_F(MeshGoalTest, says_why_there_can_be_no_pose)
{
  look(viewAt(2.5, 1.0));
  EXPECT_TRUE(says("Press the left button")) << said;
  EXPECT_EQ(press(325, 240), 0);
  EXPECT_TRUE(says("no mesh is shown")) << said;
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::terrain(200, [](double, double) { return 0.0; })));
  look({{0, -3, 3}, {0, 0, 0}});
  press(325, 240);
  EXPECT_TRUE(says("is being prepared")) << said;
  waitUntilPrepared();
  press(2, 2);
  EXPECT_TRUE(says("no surface under the cursor")) << said;
  EXPECT_EQ(release(325, 240), 0);
  auto event = mouse(325, 240, QEvent::MouseButtonPress, Qt::LeftButton);
  event.viewport = nullptr;
  event.panel = nullptr;
  EXPECT_EQ(tool->processMouseEvent(event), 0);
}

TEST_F(MeshGoalTest, a_mesh_that_goes_while_dragging_does_no_harm)
{
  auto* display = showSquare(tilted, "tilted");
  look(viewAt(2.5, 1.0));
  const Vector point = onPlane(325, 240, tilted.position, normal());
  press(325, 240);
  ASSERT_TRUE(show(display, test_meshes::square(0.7)));
  move(400, 240);
  delete display;
  spinFrames();
  EXPECT_EQ(release(420, 252), FINISHED);
  const Vector cursor = onPlane(420, 252, tilted.position, normal());
  expectAxes(axesOf(next().pose), point, minus(cursor, point), normal());
}
