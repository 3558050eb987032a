// From a property of the display to the pixels.
#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>
#include <osmesa_harness/render_fixture.h>

#include "coloring/color_scale.h"
#include "coloring/cost_coloring.h"
#include "legend/legend_picture.h"
#include "support/display_fixture.h"
#include "support/layout_checks.h"
#include "support/legend_checks.h"

using legend_checks::toRgb;
using osmesa_harness::Image;
using osmesa_harness::imagesMatch;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;

namespace {

const Rgb GREEN{0, 255, 0};
constexpr std::size_t SQUARE = 200 * 200;  // pixels of [-1, 1]² from above

/// Squares of 0.5 m side by side along the x-axis, the middle one around the origin, each with four
/// vertices of its own.
mesh_msgs::MeshGeometryStamped squares(std::uint32_t count)
{
  auto message = test_meshes::emptyMesh();
  for (std::uint32_t i = 0; i < count; ++i) {
    const double left = 0.5 * i - 0.25 * count;
    for (const double x : {left, left + 0.5}) {
      for (const double y : {-0.25, 0.25}) {
        message.mesh_geometry.vertices.push_back(test_meshes::point(x, y, 0.0));
      }
    }
    test_meshes::addFace(message, 4 * i, 4 * i + 2, 4 * i + 3);
    test_meshes::addFace(message, 4 * i, 4 * i + 3, 4 * i + 1);
  }
  return message;
}

std::size_t pixelsThatDiffer(const Image& a, const Image& b)
{
  std::size_t count = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      count += !isNear(a.at(x, y), b.at(x, y), 2);
    }
  }
  return count;
}

}  // namespace

class DisplayProperties : public DisplayFixture
{
 protected:
  void TearDown() override
  {
    resizePanel(DEFAULT_WIDTH, DEFAULT_HEIGHT);
    DisplayFixture::TearDown();
  }

  static Image picture()
  {
    viewFromAbove();
    return grab();
  }

  static void setScale(Display* display, const char* name)
  {
    set(display, {"Display Type", "Color Scale"}, name);
  }

  /// A display of a cost layer with its legend.
  Display* createCosts(std::uint32_t count)
  {
    Display* display = createMeshDisplay();
    set(display, {"Display Type"}, "Vertex Costs");
    set(display, {"Display Type", "Vertex Costs Type"}, "roughness");
    set(display, {"Display Type", "Legend"}, true);
    EXPECT_TRUE(show(display, squares(count)));
    std::vector<float> values;
    for (std::uint32_t i = 0; i < count; ++i) {
      values.insert(values.end(), 4, static_cast<float>(i) / static_cast<float>(count - 1));
    }
    costs.publish(test_meshes::costs("roughness", values));
    EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "costs from 0 to 1"));
    return display;
  }
};

TEST_F(DisplayProperties, culling_leaves_out_backs_or_fronts)
{
  auto* display = createMeshDisplay();
  const struct
  {
    const char* mode;
    bool fronts, backs;
  } modes[] = {{"None", true, true}, {"Clockwise", true, false}, {"Anticlockwise", false, true}};
  for (const bool backs : {false, true}) {
    const auto square = test_meshes::square();
    ASSERT_TRUE(show(display, backs ? test_meshes::flipped(square) : square));
    for (const auto& mode : modes) {
      set(display, {"Culling Mode (HW)"}, mode.mode);
      EXPECT_EQ(picture().count(GREEN), (backs ? mode.backs : mode.fronts) ? SQUARE : 0u)
          << mode.mode << (backs ? ", backs" : ", fronts");
    }
  }
}

TEST_F(DisplayProperties, shading_is_smooth_or_flat)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(
      show(display, test_meshes::terrain(2, [](double x, double) { return -std::abs(x); })));
  const Image smooth = picture();
  EXPECT_TRUE(isNear(smooth.center(), GREEN, 3)) << smooth.center() << " along the ridge";
  set(display, {"Shading"}, "Flat");
  const double slope = std::sqrt(0.5), above = 0.8 + 0.2 * slope;  // the light from there
  const auto lit = static_cast<std::uint8_t>(std::lround(255.0 * (0.4 + 0.6 * slope) * above));
  EXPECT_EQ(picture().count({0, lit, 0}, 1), SQUARE);
  EXPECT_LT(smooth.count({0, lit, 0}, 1), SQUARE / 4);
  set(display, {"Shading"}, "Smooth");
  EXPECT_TRUE(imagesMatch("smooth_again", picture(), smooth, 1e-6));
}

TEST_F(DisplayProperties, level_of_detail_merges_faces_below_so_many_pixels)
{
  auto* display = createMeshDisplay();
  set(display, {"Shading"}, "Flat");
  set(display, {"Level of Detail"}, false);
  ASSERT_TRUE(show(display, test_meshes::terrain(100, [](double x, double y) {
                     return 0.05 * std::sin(60.0 * x) * std::sin(50.0 * y);
                   })));
  const Image all = picture();
  EXPECT_EQ(all.count({48, 48, 48}), 640u * 480u - SQUARE);
  set(display, {"Level of Detail"}, true);
  set(display, {"Level of Detail", "Detail in pixels"}, 0.1f);
  EXPECT_EQ(pixelsThatDiffer(picture(), all), 0u) << "all faces are larger than that";
  set(display, {"Level of Detail", "Detail in pixels"}, 100.0f);
  const std::size_t merged = pixelsThatDiffer(picture(), all);
  if (layout_checks::canSimplify()) {
    EXPECT_GT(merged, SQUARE / 4);
  } else {
    EXPECT_EQ(merged, 0u);
  }
  set(display, {"Level of Detail"}, false);
  EXPECT_EQ(pixelsThatDiffer(picture(), all), 0u);
}

TEST_F(DisplayProperties, each_color_scale_is_that_of_the_mesh_and_of_its_legend)
{
  constexpr std::uint32_t COUNT = 5;
  auto* display = createCosts(COUNT);
  for (const auto& named : rviz_mesh_plugin::colorScales()) {
    setScale(display, named.name);
    rviz_mesh_plugin::LegendContent content{"roughness", "", {}, {0.0f, 1.0f}};
    content.coloring.scale = named.scale;
    const Image image = picture();
    for (std::uint32_t i = 0; i < COUNT; ++i) {
      const Rgb expected = toRgb(scaleColor(named.scale, 0.25f * i));
      int wrong = 0;
      for (int y = 215; y < 265; ++y) {
        for (int x = 195 + 50 * i; x < static_cast<int>(245 + 50 * i); ++x) {
          wrong += !isNear(image.at(x, y), expected, 1);
        }
      }
      EXPECT_EQ(wrong, 0) << named.name << ", square " << i << ": " << image.at(220 + 50 * i, 240)
                          << " instead of " << expected;
    }
    const auto legend = drawLegend(content, rviz_mesh_plugin::LEGEND_HEIGHT);
    EXPECT_EQ(legend_checks::differences(image, legend), 0) << named.name;
  }
}

TEST_F(DisplayProperties, a_legend_without_room_is_missed_in_the_status)
{
  auto* display = createCosts(2);
  const auto told = [&] {
    picture();
    return status(display, "Costs").find("the legend is left out: the 3D view is too small") !=
           std::string::npos;
  };
  EXPECT_FALSE(told());
  resizePanel(400, 100);
  EXPECT_TRUE(spinUntil(told)) << status(display, "Costs");
  EXPECT_EQ(status(display, "Costs").rfind("Ok: ", 0), 0u);
  set(display, {"Display Type", "Legend"}, false);
  EXPECT_TRUE(spinUntil([&] { return !told(); })) << "nobody asks for it";
  set(display, {"Display Type", "Legend"}, true);
  EXPECT_TRUE(spinUntil(told)) << status(display, "Costs");
  resizePanel(DEFAULT_WIDTH, DEFAULT_HEIGHT);
  EXPECT_TRUE(spinUntil([&] { return !told(); })) << status(display, "Costs");
}
