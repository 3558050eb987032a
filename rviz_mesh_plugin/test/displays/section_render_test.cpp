// A mesh of which only a box is drawn.
#include <cmath>
#include <memory>
#include <string>

#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <rviz/frame_manager.h>
#include <rviz/visualization_manager.h>
#include <tf2_ros/buffer.h>

#include "base/hidden_faces.h"
#include "support/display_fixture.h"
#include "support/label_display_fixture.h"
#include "support/label_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;

namespace {

const Rgb GREEN{0, 255, 0};
const Rgb RED{255, 0, 0};
const Rgb BLUE{0, 0, 255};
const Rgb BLACK{0, 0, 0};

/// A floor at z = 0 (faces 0, 1) below a roof at z = 1 (faces 2, 3).
mesh_msgs::MeshGeometryStamped storeys()
{
  auto message = test_meshes::square(0.0);
  const auto roof = test_meshes::square(1.0);
  for (const auto& vertex : roof.mesh_geometry.vertices) {
    message.mesh_geometry.vertices.push_back(vertex);
  }
  for (auto face : roof.mesh_geometry.faces) {
    for (auto& index : face.vertex_indices) {
      index += 4;
    }
    message.mesh_geometry.faces.push_back(face);
  }
  return message;
}

}  // namespace

class SectionTest : public LabelDisplayFixture
{
 protected:
  using Mesh = DisplayFixture::Display;

  Mesh* showStoreys()
  {
    auto* display = createMeshDisplay();
    set(display, {"Display Type"}, "Vertex Color");
    std::vector<std_msgs::ColorRGBA> values(4, test_meshes::color(1, 0, 0));
    values.resize(8, test_meshes::color(0, 0, 1));
    colors.publish(test_meshes::colors(values));
    EXPECT_TRUE(show(display, storeys()));
    EXPECT_TRUE(spinUntil([&] { return display->attributes(*display->mesh()).colors != nullptr; }));
    viewFromAbove();
    return display;
  }

  void cut(Mesh* display, const char* limit, float value)
  {
    set(display, {"Section", limit}, value);
    set(display, {"Section"}, true);
  }

  static int pixels(const Image& image, const Rgb& color)
  {
    return static_cast<int>(image.count(color));
  }
};

TEST_F(SectionTest, one_storey_is_seen_below_the_other)
{
  auto* display = showStoreys();
  EXPECT_EQ(pixels(grab(), BLUE), 200 * 200);
  cut(display, "Max Height", 0.5f);
  const Image below = grab();
  EXPECT_EQ(pixels(below, RED), 200 * 200);
  EXPECT_EQ(pixels(below, BLUE), 0);
  cut(display, "Max Height", 0.0f);
  EXPECT_EQ(pixels(grab(), RED), 200 * 200) << "a floor in the plane of the limit is drawn in full";
  cut(display, "Min Height", 1.0f);
  cut(display, "Max Height", 1.0f);
  EXPECT_EQ(pixels(grab(), BLUE), 200 * 200);
  set(display, {"Section"}, false);
  EXPECT_EQ(pixels(grab(), BLUE), 200 * 200);
}

TEST_F(SectionTest, faces_are_cut_where_the_box_ends_with_their_edges_and_normals)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  viewFromAbove();
  cut(display, "Max X", 0.25f);
  cut(display, "Min Y", -0.5f);
  const Image faces = grab();
  EXPECT_NEAR(pixels(faces, GREEN), 125 * 150, 150);
  EXPECT_EQ(faces.at(344, 240), GREEN);
  EXPECT_NE(faces.at(347, 240), GREEN);
  set(display, {"Show Wireframe"}, true);
  const Image lines = grab();
  int beside = 0;
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      beside += lines.at(x, y) == BLACK && (x > 346 || y > 291) ? 1 : 0;
    }
  }
  EXPECT_EQ(beside, 0);
  EXPECT_GT(pixels(lines, BLACK), 340) << "left and upper side, and the diagonal";
  set(display, {"Display Type"}, "Hide Faces");
  set(display, {"Show Wireframe"}, false);
  set(display, {"Show Normals"}, true);
  set(display, {"Show Normals", "Normals Scaling Factor"}, 1.0f);
  lookAt({0, -6, 0.5}, {0, 0, 0.5});
  cut(display, "Max X", 5.0f);
  cut(display, "Min Y", -5.0f);
  const int whole = pixels(grab(), Rgb{255, 0, 255});
  cut(display, "Max Height", 0.5f);
  EXPECT_NEAR(pixels(grab(), Rgb{255, 0, 255}), whole / 2, whole / 10);
}

TEST_F(SectionTest, the_box_lies_along_the_axes_of_the_mesh)
{
  // Turned by 90 degrees about z: x of the mesh points to y of the map.
  auto* display = createMeshDisplay();
  auto message = test_meshes::square();
  message.header.frame_id = "turned";
  geometry_msgs::TransformStamped turn;
  turn.header.frame_id = "map";
  turn.header.stamp = ros::Time::now();
  turn.child_frame_id = "turned";
  turn.transform.rotation.w = turn.transform.rotation.z = std::sqrt(0.5);
  manager()->getFrameManager()->getTF2BufferPtr()->setTransform(turn, "test", true);
  ASSERT_TRUE(show(display, message));
  viewFromAbove();
  cut(display, "Max X", 0.0f);
  const Image image = grab();
  EXPECT_NEAR(pixels(image, GREEN), 200 * 100, 250);
  EXPECT_EQ(image.at(250, 300), GREEN) << "below the middle";
  EXPECT_EQ(image.at(390, 300), GREEN);
  EXPECT_NE(image.at(250, 180), GREEN);
}

TEST_F(SectionTest, whole_parts_beside_it_cost_nothing)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::terrain(300, [](double, double) { return 0.0; })));
  viewFromAbove();
  set(display, {"Level of Detail"}, false);
  grab();
  const std::size_t all = display->visual()->facesDrawn();
  EXPECT_EQ(all, 2u * 300 * 300);
  cut(display, "Max X", -0.5f);
  grab();
  EXPECT_GE(display->visual()->facesDrawn(), all / 4);
  EXPECT_LE(display->visual()->facesDrawn(), all / 2);
}

TEST_F(SectionTest, labels_are_cut_with_the_mesh)
{
  server->addLabel("tree_1", {2, 3});  // the roof
  auto* display = showStoreys();
  auto* labels = createLabels();
  ASSERT_TRUE(says(labels, "Labels", "1 label"));
  const Rgb tree = test_labels::colorOf("tree");
  ASSERT_TRUE(spinUntil([&] { return pixels(grab(), tree) > 30000; }));
  cut(display, "Max Height", 0.5f);
  EXPECT_EQ(pixels(grab(), tree), 0);
  EXPECT_EQ(pixels(grab(), RED), 200 * 200);
  cut(display, "Max Height", 5.0f);
  cut(display, "Max X", 0.0f);
  EXPECT_NEAR(pixels(grab(), tree), 100 * 200, 250);
  display->setEnabled(false);
  EXPECT_GT(pixels(grab(), tree), 30000) << "a display that is hidden cuts nothing";
}

/// For people to look at: a house with a roof, from outside and with its storey laid open.
TEST_F(SectionTest, a_house_is_looked_into)
{
  // The middle of the roof, y in [-1, 1], on walls at the border and along y = 0 up to z = 0.6.
  const auto isWall = [](double x, double y) {
    return std::fabs(x) > 0.94 || std::fabs(y) > 0.94 || (std::fabs(y) < 0.04 && x < 0.3);
  };
  auto house =
      test_meshes::terrain(50, [&](double x, double y) { return isWall(x, y) ? 0.6 : 0.0; });
  const auto roof =
      test_meshes::terrain(50, [](double, double y) { return 1.2 - 0.5 * std::fabs(y); });
  const auto first = static_cast<std::uint32_t>(house.mesh_geometry.vertices.size());
  for (const auto& vertex : roof.mesh_geometry.vertices) {
    house.mesh_geometry.vertices.push_back(vertex);
  }
  for (auto face : roof.mesh_geometry.faces) {
    test_meshes::addFace(house, first + face.vertex_indices[0], first + face.vertex_indices[1],
                         first + face.vertex_indices[2]);
  }
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Fixed Color");
  set(display, {"Display Type", "Faces Color"}, QColor(180, 180, 190));
  server->addLabel("tree_1", test_labels::rows(50, 10, 14));
  ASSERT_TRUE(show(display, house));
  auto* labels = createLabels();
  ASSERT_TRUE(says(labels, "Labels", "1 label"));
  lookAt({2.2, -2.2, 2.6}, {0, 0, 0.3});
  const Image outside = grab();
  outside.save(osmesa_harness::resultsFolder() + "/section_whole.png");
  cut(display, "Max Height", 0.5f);
  const auto blue = [](const Image& image) {  // the color of trees, in whatever light
    int count = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        count += image.at(x, y).blue > image.at(x, y).red + 40 ? 1 : 0;
      }
    }
    return count;
  };
  ASSERT_TRUE(spinUntil([&] { return blue(grab()) > 4000; })) << blue(grab());
  EXPECT_LT(2 * blue(outside), blue(grab())) << "the roof hides it";
  set(display, {"Show Wireframe"}, true);
  grab().save(osmesa_harness::resultsFolder() + "/section_storey.png");
}

TEST_F(SectionTest, the_status_says_so)
{
  auto* display = showStoreys();
  EXPECT_EQ(status(display, "Section"), "");
  cut(display, "Max Height", 0.5f);
  EXPECT_TRUE(says(display, "Section",
                   "the mesh is cut: what is drawn, pointed at and selected is "
                   "height to 0.5 m; the mesh reaches from height 0 to 1 m"));
  cut(display, "Min Height", 3.0f);
  EXPECT_TRUE(says(display, "Section", "turn the limits round"));
  EXPECT_EQ(pixels(grab(), RED) + pixels(grab(), BLUE), 0);
  set(display, {"Section"}, false);
  EXPECT_TRUE(spinUntil([&] { return status(display, "Section").empty(); }));
}

TEST_F(SectionTest, it_warns_where_no_face_is_left)
{
  auto* display = showStoreys();
  cut(display, "Min Height", 0.25f);
  cut(display, "Max Height", 0.75f);
  EXPECT_TRUE(waitForStatus(display, "Section", "Warn", "no face of the mesh is at height"));
  EXPECT_EQ(pixels(grab(), RED) + pixels(grab(), BLUE), 0);
  cut(display, "Max Height", 1.5f);
  EXPECT_TRUE(waitForStatus(display, "Section", "Ok", "the mesh is cut"));
  using rviz_mesh_plugin::FaceBits;
  const auto hide = [&](const FaceBits::Faces& faces) {
    rviz_mesh_plugin::setHiddenFaces(
        *display->mesh(), std::make_shared<rviz_mesh_plugin::HiddenFaces>(FaceBits(4, faces)));
  };
  hide({2, 3});
  EXPECT_TRUE(waitForStatus(display, "Hidden", "Warn", "2 of 4 faces are hidden, all of the"));
  EXPECT_TRUE(waitForStatus(display, "Section", "Ok", "the mesh is cut"));
  set(display, {"Section"}, false);
  EXPECT_TRUE(waitForStatus(display, "Hidden", "Ok", "2 of 4 faces are hidden"));
  hide({});
}

TEST_F(SectionTest, it_stays_with_new_colors_and_new_meshes)
{
  auto* display = showStoreys();
  cut(display, "Max Height", 0.5f);
  colors.publish(
      test_meshes::colors(std::vector<std_msgs::ColorRGBA>(8, test_meshes::color(0, 1, 0))));
  ASSERT_TRUE(spinUntil([&] { return pixels(grab(), GREEN) == 200 * 200; }));
  auto other = storeys();
  other.uuid = "other";
  for (auto& vertex : other.mesh_geometry.vertices) {
    vertex.x *= vertex.z > 0.5 ? 1.0 : 0.5;
  }
  colors.publish(test_meshes::colors(
      std::vector<std_msgs::ColorRGBA>(8, test_meshes::color(1, 0, 0)), "other"));
  ASSERT_TRUE(show(display, other));
  EXPECT_TRUE(spinUntil([&] { return pixels(grab(), RED) == 100 * 200; }));
}
