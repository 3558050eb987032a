#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include <geometry_msgs/PointStamped.h>
#include <mesh_msgs/LayerInfoArray.h>
#include <mesh_msgs/MeshFaceCluster.h>

#include "displays/cluster_label_display.h"
#include "surface_tool_fixture.h"
#include "tools/mesh_inspect_tool.h"

using rviz_mesh_plugin::ClusterLabelDisplay;
using rviz_mesh_plugin::MeshInspectTool;

namespace {

const osmesa_harness::Rgb LINE{255, 255, 51};

std::string meters(double length)
{
  char text[64];
  std::snprintf(text, sizeof(text), "%.3f m", length);
  return text;
}

}  // namespace

class MeshInspectTest : public SurfaceToolFixture<MeshInspectTool, geometry_msgs::PointStamped>
{
 protected:
  /// Seen from above: 100 pixels a meter.
  void fromAbove()
  {
    viewFromAbove();
    spinFrames();
  }
  static double xOf(int pixel) { return (pixel + 0.5 - 320) / 100.0; }
  static double yOf(int pixel) { return (240 - pixel - 0.5) / 100.0; }

  /// Waits for the point under a still cursor.
  testing::AssertionResult hovers(int x, int y, const std::string& text)
  {
    move(x, y, Qt::NoButton);
    if (wait([&] { return says(text); })) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << said;
  }

  /// As RViz does, the tool is updated each frame.
  template <class Done>
  bool wait(const Done& done)
  {
    return spinUntil([&] {
      tool->update(0.03f, 0.03f);
      return done();
    });
  }
  osmesa_harness::Image picture()
  {
    tool->update(0.03f, 0.03f);
    return grab();
  }

  void click(int x, int y)
  {
    press(x, y);
    release(x, y);
  }

  /// Flat for x < 0, and 45 degrees up from there.
  static mesh_msgs::MeshGeometryStamped fold()
  {
    return test_meshes::terrain(20, [](double x, double) { return std::max(0.0, x); });
  }
  static double unfolded(double x) { return x > 0 ? std::sqrt(2.0) * x : x; }

  Display* showGray(mesh_msgs::MeshGeometryStamped message, const std::string& frame = "map")
  {
    auto* display = createMeshDisplay();
    DisplayFixture::set(display, {"Display Type", "Faces Color"}, QColor(120, 130, 160));
    message.header.frame_id = frame;
    EXPECT_TRUE(show(display, message));
    EXPECT_TRUE(spinUntil([&] { return display->shownMeshes().size() == 1; }));
    waitUntilPrepared();
    fromAbove();
    return display;
  }
};

TEST_F(MeshInspectTest, tells_all_that_is_known_of_the_point_under_the_cursor)
{
  EXPECT_EQ(tool->getShortcutKey(), 'q');
  auto* display = showSquare({{0.5, 0.25, 1}, {1, 0, 0, 0}}, "moved");
  fromAbove();
  EXPECT_TRUE(
      hovers(340, 220,
             "face 1, vertex 0 · (-0.295, -0.055, 0.000) in moved · (0.205, 0.195, 1.000) in map"));
  // Linear costs are the same everywhere on the face: x + 2 y.
  costs.publish(test_meshes::costs("sum", {-3, -1, 1, 3}));
  costs.publish(
      test_meshes::costs("edge", {std::numeric_limits<float>::infinity(), 1, std::nanf(""), 2}));
  ASSERT_TRUE(spinUntil([&] { return display->costTypes().size() == 2; }));
  auto* labels = createDisplayAs<ClusterLabelDisplay>("rviz_mesh_plugin/ClusterLabel");
  const std::string label_topic = topic + "/labels";
  const auto publisher = node.advertise<mesh_msgs::MeshFaceCluster>(label_topic, 10, true);
  DisplayFixture::set(labels, {"Geometry Topic"}, geometry_topic.c_str());
  DisplayFixture::set(labels, {"Labels Topic"}, label_topic.c_str());
  mesh_msgs::MeshFaceCluster cluster;
  cluster.label = "floor_1";
  cluster.face_indices = {1};
  publisher.publish(cluster);
  ASSERT_TRUE(spinUntil([&] { return labels->labels().size() == 1; }));
  // In the fixed frame, the middle of the square is at (0.5, 0.25).
  EXPECT_TRUE(
      hovers(395, 240, " in moved · (0.755, -0.005, 1.000) in map · sum -0.255 · edge lethal"));
  EXPECT_TRUE(says("face 0, vertex 1")) << said;
  EXPECT_TRUE(hovers(320, 180, "face 1, vertex 2 · (-0.495, 0.345, 0.000) in moved"));
  EXPECT_TRUE(says("· label floor_1 · sum 0.195 · edge lethal")) << said;
  labels->setEnabled(false);
  EXPECT_TRUE(hovers(320, 180, "in map · sum 0.195"));
  move(2, 2, Qt::NoButton);
  EXPECT_TRUE(hovers(3, 3, "no surface under the cursor: point at a mesh"));
}

TEST_F(MeshInspectTest, says_which_layers_close_a_place)
{
  auto* display = showSquare({}, "map");
  fromAbove();
  costs.publish(test_meshes::costs("slope", {0, 0, 0, 9}));
  costs.publish(test_meshes::costs("border", {0.25, 0.25, 0.25, 0.25}));
  costs.publish(test_meshes::costs("Combined Costs",
                                   std::vector<float>(4, std::numeric_limits<float>::infinity())));
  ASSERT_TRUE(spinUntil([&] { return display->costTypes().size() == 3; }));
  auto info = node.advertise<mesh_msgs::LayerInfoArray>(
      ros::names::parentNamespace(geometry_topic) + "/layer_info", 1, true);
  mesh_msgs::LayerInfoArray message;
  message.uuid = test_meshes::square().uuid;
  message.layers.resize(3);
  message.layers[0].name = "slope";
  message.layers[0].layer_type = "mesh_layers/SteepnessLayer";
  message.layers[0].unit = "rad";
  message.layers[0].comparison = mesh_msgs::LayerInfo::ABOVE;
  message.layers[0].threshold = 0.5f;
  message.layers[1].name = "border";
  message.layers[1].layer_type = "mesh_layers/BorderLayer";
  message.layers[1].comparison = mesh_msgs::LayerInfo::AT_LEAST;
  message.layers[1].threshold = 0.25f;
  message.layers[2].name = "Combined Costs";
  info.publish(message);
  ASSERT_TRUE(
      spinUntil([&] { return !display->layerInfo(*display->mesh(), "slope").unit.empty(); }));
  // Both faces touch vertex 3, by which the slope is lethal there.
  EXPECT_TRUE(hovers(340, 220,
                     "closed by slope (lethal above 0.5 rad), border (lethal from 0.25) · slope "))
      << said;
  EXPECT_TRUE(says(" rad · border 0.25 · Combined Costs lethal")) << said;
}

TEST_F(MeshInspectTest, says_why_there_is_nothing)
{
  EXPECT_TRUE(says("Point at a mesh")) << said;
  fromAbove();
  EXPECT_TRUE(hovers(320, 240, "no mesh is shown"));
  click(320, 240);
  EXPECT_TRUE(says("Nothing can be marked: no mesh is shown")) << said;
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::terrain(200, [](double, double) { return 0.0; })));
  click(320, 240);
  EXPECT_TRUE(says("is being prepared")) << said;
  auto event = mouse(320, 240);
  event.viewport = nullptr;
  event.panel = nullptr;
  EXPECT_EQ(tool->processMouseEvent(event), 0);
  spinFrames();
  EXPECT_TRUE(received.empty());
}

TEST_F(MeshInspectTest, a_click_publishes_the_point_in_the_fixed_frame)
{
  const FixedPose tilted{{0.3, -0.2, 0.4}, {0.9, 0.25, -0.2, 0.3}};
  showSquare(tilted, "tilted");
  const Vector normal = minus(tilted({0, 0, 1}), tilted.position);
  look({plus(plus(tilted.position, 2.5, normal), 0.7, {0, 1, 0}), tilted.position});
  click(355, 210);
  const Vector expected = onPlane(355, 210, tilted.position, normal);
  const auto message = next();
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_LT(std::abs((message.header.stamp - ros::Time::now()).toSec()), 60.0);
  EXPECT_NEAR(message.point.x, expected[0], 1e-5);
  EXPECT_NEAR(message.point.y, expected[1], 1e-5);
  EXPECT_NEAR(message.point.z, expected[2], 1e-5);
  EXPECT_TRUE(says("The point was published on " + topic)) << said;
}

TEST_F(MeshInspectTest, two_clicks_measure_along_the_surface_and_draw_the_way)
{
  putFrame("fold", {});
  auto* display = showGray(fold(), "fold");
  EXPECT_EQ(picture().count(LINE, 60), 0u);
  const auto nodes = counts().nodes;
  click(247, 301);
  click(372, 157);
  EXPECT_TRUE(says("Measuring the way")) << said;
  const double along = std::hypot(unfolded(xOf(372)) - unfolded(xOf(247)), yOf(157) - yOf(301));
  const double direct = std::hypot(xOf(372) - xOf(247), yOf(157) - yOf(301), xOf(372));
  const std::string text =
      "Distance " + meters(along) + " along the surface, " + meters(direct) + " in a straight line";
  ASSERT_TRUE(wait([&] { return says("Distance"); })) << said;
  EXPECT_TRUE(says(text)) << said << "\nexpected: " << text;
  EXPECT_TRUE(hovers(400, 240, "in map")) << said;
  EXPECT_TRUE(says(text)) << "it stays while hovering: " << said;
  const auto drawn = picture();
  drawn.save(osmesa_harness::resultsFolder() + "/mesh_inspect_way.png");
  EXPECT_GT(drawn.count(LINE, 60), 300u);
  // Where the way crosses the fold, unfolded into the plane.
  const double share = -xOf(247) / (unfolded(xOf(372)) - xOf(247));
  const double y = yOf(301) + share * (yOf(157) - yOf(301));
  const int row = static_cast<int>(240 - 100 * y);
  EXPECT_TRUE(osmesa_harness::isNear(drawn.at(320, row), LINE, 60));
  EXPECT_FALSE(osmesa_harness::isNear(drawn.at(320, row + 12), LINE, 60));
  // It goes with the mesh.
  putFrame("fold", {{0.5, 0, 0}, {1, 0, 0, 0}});
  ASSERT_TRUE(spinUntil([&] { return display->shownMeshes().at(0).position.x > 0.4; }));
  const auto moved = picture();
  EXPECT_TRUE(osmesa_harness::isNear(moved.at(370, row), LINE, 60));
  EXPECT_FALSE(osmesa_harness::isNear(moved.at(320, row), LINE, 60));
  display->setEnabled(false);
  EXPECT_EQ(picture().count(LINE, 60), 0u) << "hidden with the mesh";
  display->setEnabled(true);
  spinFrames();
  EXPECT_GT(picture().count(LINE, 60), 300u);
  look({{-1.5, -3, 3}, {0.4, 0, 0.3}});
  set({"Marker Size"}, 0.2);
  const auto aslant = picture();
  aslant.save(osmesa_harness::resultsFolder() + "/mesh_inspect_aslant.png");
  // A third click begins anew.
  fromAbove();
  click(372, 157);
  EXPECT_TRUE(says("The point was published")) << said;
  EXPECT_EQ(picture().count(LINE, 60), 0u);
  EXPECT_EQ(pressEscape(), rviz::Tool::Render);
  spinFrames();
  EXPECT_EQ(counts().nodes, nodes) << "all marks are gone";
}

TEST_F(MeshInspectTest, points_that_no_way_connects)
{
  auto message = test_meshes::square();
  auto other = test_meshes::square();
  for (auto& vertex : other.mesh_geometry.vertices) {
    vertex.x += 2.1;
    message.mesh_geometry.vertices.push_back(vertex);
  }
  for (const auto& face : other.mesh_geometry.faces) {
    const auto& v = face.vertex_indices;
    test_meshes::addFace(message, v[0] + 4, v[1] + 4, v[2] + 4);
  }
  showGray(message);
  click(320, 240);
  click(500, 240);
  EXPECT_TRUE(wait([&] {
    return says("The points are not connected along the surface; 1.800 m in a straight line");
  })) << said;
  EXPECT_EQ(picture().count(LINE, 60), 0u);
}

TEST_F(MeshInspectTest, points_of_two_meshes)
{
  auto* first = showGray(test_meshes::square());
  first->setName("first");
  auto* second = createMeshDisplay();
  second->setName("second");
  const std::string other_topic = geometry_topic + "/other";
  const auto publisher = node.advertise<mesh_msgs::MeshGeometryStamped>(other_topic, 1, true);
  DisplayFixture::set(second, {"Geometry Topic"}, other_topic.c_str());
  auto message = test_meshes::square();
  message.header.frame_id = "aside";
  putFrame("aside", {{2.1, 0, 1}, {1, 0, 0, 0}});
  publisher.publish(message);
  ASSERT_TRUE(spinUntil([&] { return second->shownMeshes().size() == 1; }));
  waitUntilPrepared();
  click(320, 240);
  click(500, 240);
  EXPECT_TRUE(says("The points are on different meshes, " + meters(std::hypot(1.8, 1.0)))) << said;
  EXPECT_EQ(next().point.z, 0.0);
  EXPECT_NEAR(next().point.z, 1.0, 1e-6);
  delete second;
  EXPECT_TRUE(wait([&] { return says("is gone"); })) << said;
}

TEST_F(MeshInspectTest, a_mesh_that_goes_takes_its_marks_and_measurement_with_it)
{
  auto* display = showGray(test_meshes::terrain(150, [](double x, double y) { return x * y; }));
  const auto nodes = counts().nodes;
  click(247, 301);
  click(372, 157);
  delete display;
  EXPECT_TRUE(wait([&] { return says("The mesh of the markers is gone"); })) << said;
  spinFrames();
  EXPECT_LT(counts().nodes, nodes);
  // Left, and destroyed, in the middle of measuring.
  showGray(test_meshes::terrain(150, [](double x, double y) { return x * x - y; }));
  click(247, 301);
  click(372, 157);
  tool->deactivate();
  tool->activate();
  click(247, 301);
  click(372, 157);
  tool.reset();
  spinFrames();
}
