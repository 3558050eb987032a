#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rviz/display_group.h>
#include <rviz/properties/property.h>
#include <rviz/render_panel.h>
#include <rviz/selection/selection_manager.h>
#include <rviz/visualization_manager.h>

#include "reference_picture.h"
#include "support/display_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::imagesMatch;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;

namespace {

constexpr float INF = std::numeric_limits<float>::infinity();
const Rgb BACKGROUND{48, 48, 48};
const Rgb GREEN{0, 255, 0};

double flat(double, double)
{
  return 0.0;
}

}  // namespace

/// From above at 100 pixels per meter, the square [-1, 1]² covers columns 220..419 and rows
/// 140..339.
class PixelTest : public DisplayFixture
{
 protected:
  Image picture(double pixels_per_meter = 100.0)
  {
    viewFromAbove(0.0, 0.0, pixels_per_meter);
    return grab();
  }
};

TEST_F(PixelTest, a_surface_that_faces_the_camera_has_exactly_its_color)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  const Image image = picture();
  EXPECT_EQ(image.count(GREEN), 200u * 200u);
  EXPECT_EQ(image.count(BACKGROUND), 640u * 480u - 200u * 200u);
  set(display, {"Display Type", "Faces Color"}, QColor(200, 100, 50));
  EXPECT_EQ(picture().count({200, 100, 50}), 200u * 200u);
}

TEST_F(PixelTest, light_falls_with_the_cosine_of_the_slope)
{
  auto* display = createMeshDisplay();
  for (const double slope : {0.5, 1.0, 2.0, -1.0}) {
    ASSERT_TRUE(
        show(display, test_meshes::terrain(4, [&](double x, double) { return slope * x; })));
    const double cosine = 1.0 / std::hypot(1.0, slope);
    const double above = 0.8 + 0.2 * cosine;  // the light from there
    const auto expected =
        static_cast<std::uint8_t>(std::lround(255.0 * (0.4 + 0.6 * cosine) * above));
    EXPECT_TRUE(isNear(picture().center(), {0, expected, 0}, 1))
        << slope << ": " << picture().center();
  }
}

TEST_F(PixelTest, faces_are_lit_the_same_from_both_sides_and_whichever_way_they_are_wound)
{
  auto* display = createMeshDisplay();
  const auto sloped =
      test_meshes::terrain(8, [](double x, double y) { return 0.5 * std::sin(3 * x) * y; });
  ASSERT_TRUE(show(display, sloped));
  lookAt({1.0, -2.0, 2.0}, {0.0, 0.0, 0.0});
  const Image above = grab();
  lookAt({1.0, -2.0, -2.0}, {0.0, 0.0, 0.0});
  const Image below = grab();
  EXPECT_LT(above.count(BACKGROUND), 250000u);
  EXPECT_LT(below.count(BACKGROUND), 250000u);
  ASSERT_TRUE(show(display, test_meshes::flipped(sloped)));
  EXPECT_TRUE(imagesMatch("flipped_below", grab(), below, 1e-6));
  lookAt({1.0, -2.0, 2.0}, {0.0, 0.0, 0.0});
  EXPECT_TRUE(imagesMatch("flipped_above", grab(), above, 1e-6));
  // Normals that contradict the winding change nothing either.
  auto contradicting = sloped;
  for (const auto& vertex : sloped.mesh_geometry.vertices) {
    const double x = vertex.x;
    const double y = vertex.y;
    contradicting.mesh_geometry.vertex_normals.push_back(
        test_meshes::point(1.5 * std::cos(3 * x) * y, 0.5 * std::sin(3 * x), -1.0));
  }
  ASSERT_TRUE(show(display, contradicting));
  const Image downward = grab();
  for (auto& normal : contradicting.mesh_geometry.vertex_normals) {
    normal = test_meshes::point(-normal.x, -normal.y, -normal.z);
  }
  ASSERT_TRUE(show(display, contradicting));
  EXPECT_TRUE(imagesMatch("contradicting_normals", downward, grab(), 1e-6));
}

TEST_F(PixelTest, vertex_colors_are_interpolated_over_the_faces)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::terrain(3, flat)));
  std::vector<std_msgs::ColorRGBA> values;
  std::vector<std::array<double, 3>> expected;
  for (int i = 0; i < 16; ++i) {
    expected.push_back({(i % 4) / 3.0, (i / 4) / 3.0, (i % 3) / 2.0});
    values.push_back(test_meshes::color(expected[i][0], expected[i][1], expected[i][2]));
  }
  set(display, {"Display Type"}, "Vertex Color");
  EXPECT_EQ(picture().center(), (Rgb{153, 153, 153})) << "grey without colors";
  colors.publish(test_meshes::colors(values));
  ASSERT_TRUE(waitForStatus(display, "Colors", "Ok", "16 colors"));
  EXPECT_TRUE(imagesMatch("vertex_colors", picture(),
                          referencePicture(640, 480, 100.0, 3, expected), 1e-5));
}

TEST_F(PixelTest, costs_have_the_colors_of_the_rainbow)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::terrain(5, flat)));
  const std::vector<std::array<double, 3>> stops{{1, 0, 1}, {0, 0, 1}, {0, 1, 1},
                                                 {0, 1, 0}, {1, 1, 0}, {1, 0, 0}};
  std::vector<float> values;
  std::vector<std::array<double, 3>> expected;
  for (int i = 0; i < 36; ++i) {
    values.push_back(10.0f + 2.0f * (i % 6));
    expected.push_back(stops[i % 6]);
  }
  costs.publish(test_meshes::costs("roughness", values));
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "roughness");
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "36 costs from 10 to 20"));
  EXPECT_TRUE(
      imagesMatch("rainbow", picture(), referencePicture(640, 480, 100.0, 5, expected), 1e-5));
  // Red Green with limits that clamp: columns 0..5 cost 10..20, the scale runs from 12 to 16.
  const std::vector<std::array<double, 3>> clamped{{0, 1, 0}, {0, 1, 0}, {1, 1, 0},
                                                   {1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  for (int i = 0; i < 36; ++i) {
    expected[i] = clamped[i % 6];
  }
  set(display, {"Display Type", "Color Scale"}, "Red Green");
  set(display, {"Display Type", "Use Custom limits", "Vertex Costs Lower Limit"}, 12.0f);
  set(display, {"Display Type", "Use Custom limits", "Vertex Costs Upper Limit"}, 16.0f);
  set(display, {"Display Type", "Use Custom limits"}, true);
  EXPECT_TRUE(
      imagesMatch("red_green", picture(), referencePicture(640, 480, 100.0, 5, expected), 1e-5));
}

TEST_F(PixelTest, lethal_unknown_and_constant_costs_are_seen)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  const auto centerOf = [&](const std::vector<float>& values, const std::string& expected_status) {
    costs.publish(test_meshes::costs("a", values));
    EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", expected_status));
    return picture().center();
  };
  EXPECT_EQ(centerOf({7, 7, 7, 7}, "4 costs from 7 to 7"), (Rgb{255, 0, 255}));
  EXPECT_EQ(centerOf({INF, INF, INF, INF}, "4 lethal"), (Rgb{255, 20, 147}));
  EXPECT_EQ(centerOf({NAN, NAN, NAN, NAN}, "4 unknown"), (Rgb{104, 78, 40}));
}

TEST_F(PixelTest, translucent_faces_blend_and_hide_nothing)
{
  auto* display = createMeshDisplay();
  auto two = test_meshes::square(0.0);
  const auto upper = test_meshes::square(1.0);
  for (const auto& vertex : upper.mesh_geometry.vertices) {
    two.mesh_geometry.vertices.push_back(vertex);
  }
  test_meshes::addFace(two, 4, 5, 7);
  test_meshes::addFace(two, 4, 7, 6);
  set(display, {"Display Type", "Faces Alpha"}, 0.5f);
  ASSERT_TRUE(show(display, two));
  // The lower one is drawn first and the other way round; depth must not matter.
  const Rgb expected{12, 203, 12};  // (48 + green) / 2, then once more
  EXPECT_TRUE(isNear(picture().center(), expected, 1)) << picture().center();
  std::reverse(two.mesh_geometry.faces.begin(), two.mesh_geometry.faces.end());
  ASSERT_TRUE(show(display, two));
  EXPECT_TRUE(isNear(picture().center(), expected, 1)) << picture().center();
}

TEST_F(PixelTest, translucent_vertex_colors_blend)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  colors.publish(
      test_meshes::colors(std::vector<std_msgs::ColorRGBA>(4, test_meshes::color(1, 0, 0, 0.5f))));
  set(display, {"Display Type"}, "Vertex Color");
  ASSERT_TRUE(waitForStatus(display, "Colors", "Ok", "4 colors"));
  EXPECT_TRUE(isNear(picture().center(), {152, 24, 24}, 1)) << picture().center();
}

TEST_F(PixelTest, mesh_of_more_than_65536_vertices_is_drawn_to_its_last_face)
{
  auto* display = createMeshDisplay();
  set(display, {"Level of Detail"}, false);
  ASSERT_TRUE(show(display, test_meshes::terrain(300, flat)));
  EXPECT_EQ(picture().count(GREEN), 200u * 200u);
}

TEST_F(PixelTest, without_rviz_light_the_ambient_share_remains)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  rviz::Property* light =
      manager()->getRootDisplayGroup()->subProp("Global Options")->subProp("Default Light");
  light->setValue(false);
  EXPECT_TRUE(isNear(picture().center(), {0, 102, 0}, 1)) << picture().center();
  light->setValue(true);
  EXPECT_EQ(picture().center(), GREEN);
}

TEST_F(PixelTest, the_focus_tool_finds_the_surface)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square(0.25)));
  picture();
  Ogre::Vector3 hit;
  ASSERT_TRUE(manager()->getSelectionManager()->get3DPoint(panel()->getViewport(), 370, 190, hit));
  EXPECT_NEAR(hit.x, 0.5, 0.02);
  EXPECT_NEAR(hit.y, 0.5, 0.02);
  EXPECT_NEAR(hit.z, 0.25, 0.02);
}

TEST_F(PixelTest, looks_the_same_on_all_back_ends)
{
  auto* display = createMeshDisplay();
  const auto hills = test_meshes::terrain(40, [](double x, double y) {
    return 0.25 * std::sin(4 * x) * std::cos(3 * y) + 0.1 * std::sin(9 * x + 5 * y);
  });
  ASSERT_TRUE(show(display, hills));
  std::vector<float> heights;
  for (const auto& vertex : hills.mesh_geometry.vertices) {
    heights.push_back(static_cast<float>(vertex.z));
  }
  costs.publish(test_meshes::costs("height", heights));
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "height");
  set(display, {"Show Wireframe"}, true);
  set(display, {"Show Wireframe", "Wireframe Alpha"}, 0.2f);
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'height'"));
  lookAt({2.2, -2.0, 1.6}, {0.0, 0.0, 0.0});
  const Image image = grab();
  EXPECT_LT(image.count(BACKGROUND), 250000u);
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("hills", image));
}
