#include <cmath>
#include <string>
#include <vector>

#include <OgreMaterialManager.h>
#include <OgreTechnique.h>
#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <rviz/visualization_manager.h>
#include <tf2_ros/transform_broadcaster.h>

#include "support/display_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;

namespace {

const Rgb BACKGROUND{48, 48, 48};
const Rgb GREEN{0, 255, 0};
const Rgb BLACK{0, 0, 0};
const Rgb WHITE{255, 255, 255};

double flat(double, double)
{
  return 0.0;
}

/// Pixels that have one color in both pictures.
std::size_t countInBoth(const Image& a, const Image& b, const Rgb& color)
{
  std::size_t count = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      count += a.at(x, y) == color && b.at(x, y) == color ? 1 : 0;
    }
  }
  return count;
}

}  // namespace

/// Wireframe, normals, transforms and the technique for graphics without programs.
class LinesTest : public DisplayFixture
{
};

TEST_F(LinesTest, wireframe_draws_the_edges_over_the_faces)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  viewFromAbove(0.0, 0.0, 100.0);
  EXPECT_EQ(grab().count(BLACK), 0u);
  set(display, {"Show Wireframe"}, true);
  const Image image = grab();
  // Four sides and a diagonal of 200 pixels each; one pixel wide, give or take the corners.
  EXPECT_NEAR(image.count(BLACK), 1000.0, 10.0);
  EXPECT_EQ(image.at(300, 300), GREEN);
  EXPECT_EQ(image.at(319, 240), BLACK) << "on the diagonal";
  set(display, {"Show Wireframe"}, false);
  EXPECT_EQ(grab().count(BLACK), 0u);
}

TEST_F(LinesTest, hidden_faces_leave_the_edges)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  viewFromAbove(0.0, 0.0, 100.0);
  set(display, {"Display Type"}, "Hide Faces");
  EXPECT_EQ(grab().count(BACKGROUND), 640u * 480u);
  set(display, {"Show Wireframe"}, true);
  set(display, {"Show Wireframe", "Wireframe Color"}, QColor(Qt::white));
  const Image image = grab();
  EXPECT_NEAR(image.count(WHITE), 1000.0, 10.0);
  EXPECT_EQ(image.count(BACKGROUND) + image.count(WHITE), 640u * 480u);
}

TEST_F(LinesTest, wireframe_does_not_flicker_with_the_faces_it_lies_in)
{
  // On a plane no edge hides another one: the faces may not swallow any pixel that the edges alone
  // have.
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display,
                   test_meshes::terrain(12, [](double x, double y) { return 0.3 * x - 0.7 * y; })));
  set(display, {"Show Wireframe"}, true);
  for (const auto& eye : {Point{2.0, -1.5, 1.0}, Point{0.5, 2.5, 0.5}, Point{4.0, 3.0, 20.0}}) {
    lookAt(eye, {0.0, 0.0, 0.0});
    set(display, {"Display Type"}, "Hide Faces");
    const Image edges = grab();
    set(display, {"Display Type"}, "Fixed Color");
    const Image both = grab();
    EXPECT_GT(edges.count(BLACK), 1000u);
    EXPECT_GT(countInBoth(edges, both, BLACK), 0.995 * edges.count(BLACK))
        << "from height " << eye.z;
  }
}

TEST_F(LinesTest, edges_behind_faces_stay_hidden)
{
  auto* display = createMeshDisplay();
  auto message = test_meshes::terrain(10, flat);
  const auto offset = static_cast<std::uint32_t>(message.mesh_geometry.vertices.size());
  for (const auto& vertex : test_meshes::square(0.05).mesh_geometry.vertices) {
    message.mesh_geometry.vertices.push_back(vertex);
  }
  test_meshes::addFace(message, offset, offset + 1, offset + 3);
  test_meshes::addFace(message, offset, offset + 3, offset + 2);
  set(display, {"Show Wireframe"}, true);
  ASSERT_TRUE(show(display, message));
  viewFromAbove(0.0, 0.0, 100.0);
  EXPECT_NEAR(grab().count(BLACK), 1000.0, 10.0) << "only the edges of the square above are seen";
}

TEST_F(LinesTest, translucent_wireframe_blends)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  set(display, {"Show Wireframe"}, true);
  set(display, {"Show Wireframe", "Wireframe Alpha"}, 0.2f);
  viewFromAbove(0.0, 0.0, 100.0);
  const Image image = grab();
  EXPECT_EQ(image.count(BLACK), 0u);
  // The sides, once each, lie half on the mesh and half on the background; the diagonal, an edge of
  // two faces, is blended twice.
  EXPECT_NEAR(image.count({0, 204, 0}, 1), 400.0, 10.0);
  EXPECT_NEAR(image.count({38, 38, 38}, 1), 400.0, 10.0);
  EXPECT_NEAR(image.count({0, 163, 0}, 1), 200.0, 5.0);
}

TEST_F(LinesTest, normals_are_lines_of_the_given_length)
{
  auto* display = createMeshDisplay();
  auto message = test_meshes::square();
  message.mesh_geometry.vertex_normals.assign(4, test_meshes::point(2.0, 0.0, 0.0));
  ASSERT_TRUE(show(display, message));
  viewFromAbove(0.0, 0.0, 100.0);
  set(display, {"Display Type"}, "Hide Faces");
  set(display, {"Show Normals"}, true);
  set(display, {"Show Normals", "Normals Scaling Factor"}, 0.5f);
  const Rgb magenta{255, 0, 255};
  EXPECT_NEAR(grab().count(magenta), 4 * 50.0, 4.0);
  set(display, {"Show Normals", "Normals Scaling Factor"}, 0.25f);
  EXPECT_NEAR(grab().count(magenta), 4 * 25.0, 4.0);
  set(display, {"Show Normals"}, false);
  EXPECT_EQ(grab().count(magenta), 0u);
}

TEST_F(LinesTest, follows_its_frame_and_hides_while_that_is_unknown)
{
  auto* display = createMeshDisplay();
  auto message = test_meshes::square();
  message.header.frame_id = "moving";
  ASSERT_TRUE(show(display, message));
  EXPECT_TRUE(waitForStatus(display, "Transform", "Error",
                            "no transform from frame 'moving' to the fixed frame 'map'"));
  viewFromAbove(0.0, 0.0, 100.0);
  EXPECT_EQ(grab().count(GREEN), 0u);
  tf2_ros::TransformBroadcaster broadcaster;
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "map";
  transform.child_frame_id = "moving";
  transform.transform.rotation.w = 1.0;
  for (const double x : {0.0, 1.0, -0.5}) {
    transform.transform.translation.x = x;
    const int left = 220 + static_cast<int>(100.0 * x);
    Image image;
    const auto arrived = [&] {
      transform.header.stamp = ros::Time::now();
      broadcaster.sendTransform(transform);
      image = grab();
      return image.at(left, 240) == GREEN && image.at(left + 199, 240) == GREEN &&
             image.at(left - 1, 240) == BACKGROUND && image.at(left + 200, 240) == BACKGROUND;
    };
    EXPECT_TRUE(spinUntil(arrived)) << "at x = " << x;
    EXPECT_TRUE(waitForStatus(display, "Transform", "Ok",
                              "frame 'moving' is known in the fixed frame 'map'"));
  }
  EXPECT_EQ(display->visual()->geometryUploads(), 1u) << "only the node moves";
  // Another fixed frame: the mesh stands still in its own one, and is hidden in one without
  // connection.
  manager()->setFixedFrame("moving");
  viewFromAbove(0.0, 0.0, 100.0);
  EXPECT_EQ(grab().at(220, 240), GREEN);
  EXPECT_EQ(grab().at(219, 240), BACKGROUND);
  manager()->setFixedFrame("elsewhere");
  EXPECT_TRUE(waitForStatus(display, "Transform", "Error", "fixed frame 'elsewhere'"));
  EXPECT_EQ(grab().count(GREEN), 0u);
  manager()->setFixedFrame("moving");
  EXPECT_TRUE(waitForStatus(display, "Transform", "Ok", "fixed frame 'moving'"));
  EXPECT_EQ(grab().at(220, 240), GREEN);
}

TEST_F(LinesTest, without_shader_programs_faces_are_seen_from_both_sides_too)
{
  auto* display = createMeshDisplay();
  const auto sloped = test_meshes::terrain(4, [](double x, double) { return x; });
  ASSERT_TRUE(show(display, sloped));
  colors.publish(
      test_meshes::colors(std::vector<std_msgs::ColorRGBA>(25, test_meshes::color(1, 0.5f, 0))));
  ASSERT_TRUE(waitForStatus(display, "Colors", "Ok", "25 colors"));
  viewFromAbove(0.0, 0.0, 100.0);
  const auto removePrograms = [] {
    auto materials = Ogre::MaterialManager::getSingleton().getResourceIterator();
    while (materials.hasMoreElements()) {
      auto* material = dynamic_cast<Ogre::Material*>(materials.getNext().get());
      if (material && material->getName().rfind("rviz_mesh_plugin/Material", 0) == 0) {
        material->removeTechnique(0);
      }
    }
  };
  const double cosine = std::sqrt(0.5);
  const auto lit = static_cast<std::uint8_t>(std::lround(255.0 * (0.4 + 0.6 * cosine)));
  removePrograms();
  EXPECT_TRUE(isNear(grab().center(), {0, lit, 0}, 2)) << grab().center();
  set(display, {"Display Type"}, "Vertex Color");
  removePrograms();
  const auto red = static_cast<std::uint8_t>(std::lround(255.0 * cosine));
  const auto green = static_cast<std::uint8_t>(std::lround(127.5 * cosine));
  EXPECT_TRUE(isNear(grab().center(), {red, green, 0}, 2)) << grab().center();
  ASSERT_TRUE(show(display, test_meshes::flipped(sloped)));
  removePrograms();
  EXPECT_TRUE(isNear(grab().center(), {255, 128, 0}, 1)) << grab().center();
  set(display, {"Display Type"}, "Fixed Color");
  removePrograms();
  EXPECT_EQ(grab().center(), GREEN);
}
