#include "legend/legend.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <OgreViewport.h>
#include <gtest/gtest.h>
#include <osmesa_harness/render_fixture.h>
#include <rviz/display_group.h>
#include <rviz/properties/property.h>
#include <rviz/render_panel.h>
#include <rviz/selection/selection_manager.h>
#include <rviz/visualization_manager.h>
#include <QColor>
#include <QImage>

#include "legend/legend_picture.h"
#include "support/legend_checks.h"

using legend_checks::differences;
using legend_checks::DISTANCE;
using legend_checks::toRgb;
using osmesa_harness::Image;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;
using rviz_mesh_plugin::ColorScale;
using rviz_mesh_plugin::CostColoring;
using rviz_mesh_plugin::CostLimits;
using rviz_mesh_plugin::drawLegend;
using rviz_mesh_plugin::Legend;
using rviz_mesh_plugin::LEGEND_HEIGHT;
using rviz_mesh_plugin::LegendContent;
using rviz_mesh_plugin::Rgba8;

namespace {

constexpr int BAR_LEFT =
    8;  ///< columns of a legend that its bar begins, has its middle and ends at
constexpr int BAR_MIDDLE = BAR_LEFT + 9;
constexpr int BAR_RIGHT = BAR_LEFT + 18;

LegendContent content(ColorScale scale = ColorScale::RAINBOW)
{
  LegendContent content{"height_diff", "m", CostColoring(), {0.0f, 0.7f}};
  content.coloring.scale = scale;
  return content;
}

/// Rows of the bar.
struct Bar
{
  int top = -1;
  int bottom = -1;
};

/// By the outline at its left side.
Bar findBar(const QImage& picture)
{
  Bar longest;
  int length = 0;
  for (int row = 0; row < picture.height(); ++row) {
    length = picture.pixel(BAR_LEFT - 1, row) == qRgb(190, 190, 190) ? length + 1 : 0;
    if (length > longest.bottom - longest.top + 3) {
      longest = {row - length + 2, row - 1};
    }
  }
  return longest;
}

int whitePixels(const QImage& picture, const QRect& area)
{
  int count = 0;
  for (int y = area.top(); y <= area.bottom(); ++y) {
    for (int x = area.left(); x <= area.right(); ++x) {
      count += picture.rect().contains(x, y) && qGray(picture.pixel(x, y)) > 180;
    }
  }
  return count;
}

}  // namespace

class LegendTest : public osmesa_harness::RenderFixture
{
 protected:
  void show(Legend& legend, const LegendContent& shown) { legend.show(shown); }
};

TEST_F(LegendTest, the_bar_has_the_colors_of_each_scale)
{
  for (const auto& named : rviz_mesh_plugin::colorScales()) {
    for (const bool inverted : {false, true}) {
      LegendContent shown = content(named.scale);
      shown.coloring.inverted = inverted;
      const QImage picture = drawLegend(shown, LEGEND_HEIGHT);
      ASSERT_EQ(picture.height(), LEGEND_HEIGHT);
      const Bar bar = findBar(picture);
      ASSERT_GT(bar.bottom - bar.top, 150) << named.name;
      for (int row = bar.top; row <= bar.bottom; ++row) {
        const float height = static_cast<float>(bar.bottom - row) / (bar.bottom - bar.top);
        const Rgba8 expected = scaleColor(named.scale, inverted ? 1.0f - height : height);
        ASSERT_TRUE(isNear(toRgb(picture.pixel(BAR_MIDDLE, row)), toRgb(expected), 1))
            << named.name << " at " << height;
      }
    }
  }
}

TEST_F(LegendTest, ticks_stand_at_their_heights)
{
  LegendContent shown = content();
  shown.limits = {0.0f, 1.0f};
  const QImage picture = drawLegend(shown, LEGEND_HEIGHT);
  const Bar bar = findBar(picture);
  std::vector<int> ticks;
  for (int row = bar.top - 1; row <= bar.bottom + 1; ++row) {
    if (qGray(picture.pixel(BAR_RIGHT + 2, row)) > 180) {
      ticks.push_back(row);
    }
  }
  ASSERT_GE(ticks.size(), 3u);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double height = static_cast<double>(i) / static_cast<double>(ticks.size() - 1);
    EXPECT_NEAR(ticks[i], bar.top + height * (bar.bottom - bar.top), 0.51);
  }
}

TEST_F(LegendTest, marks_threshold_and_limit_and_the_lethal_part)
{
  LegendContent shown = content();
  shown.limits = {0.0f, 1.0f};
  const QImage without = drawLegend(shown, LEGEND_HEIGHT);
  const Bar plain = findBar(without);
  shown.info.comparison = rviz_mesh_plugin::LayerInfo::ABOVE;
  shown.info.threshold = 0.75f;
  shown.coloring.least_lethal = shown.info.leastLethal();
  shown.coloring.lethal = {1, 2, 250, 255};
  const QImage picture = drawLegend(shown, LEGEND_HEIGHT);
  const int rows = plain.bottom - plain.top;
  const int at = plain.top + static_cast<int>(0.25 * rows);
  for (int row = plain.top; row <= plain.bottom; ++row) {
    if (row < at - 3) {
      EXPECT_EQ(toRgb(picture.pixel(BAR_MIDDLE, row)), toRgb(shown.coloring.lethal)) << row;
    } else if (row > at + 3) {
      EXPECT_EQ(picture.pixel(BAR_MIDDLE, row), without.pixel(BAR_MIDDLE, row)) << row;
    }
  }
  const auto isMarked = [](const QImage& image, int row) {
    return qGray(image.pixel(BAR_LEFT - 3, row)) > 180;  // where the bar is not
  };
  int marks = 0;
  for (int row = plain.top; row <= plain.bottom; ++row) {
    EXPECT_FALSE(isMarked(without, row));
    if (isMarked(picture, row)) {
      ++marks;
      EXPECT_NEAR(row, at, 1);
    }
  }
  EXPECT_EQ(marks, 1);
  // Outside the limits there is nothing to be marked; the swatch says what is lethal all the same.
  shown.info.threshold = 3.0f;
  shown.coloring.least_lethal = shown.info.leastLethal();
  const QImage outside = drawLegend(shown, LEGEND_HEIGHT);
  for (int row = plain.top; row <= plain.bottom; ++row) {
    EXPECT_FALSE(isMarked(outside, row));
    EXPECT_EQ(outside.pixel(BAR_MIDDLE, row), without.pixel(BAR_MIDDLE, row)) << row;
  }
  EXPECT_GT(outside.width(), 0);
  // A limit has a line of its own below the bar.
  shown.info.cost_limit = 0.5f;
  const Bar shorter = findBar(drawLegend(shown, LEGEND_HEIGHT));
  EXPECT_LT(shorter.bottom, plain.bottom);
}

TEST_F(LegendTest, limits_the_other_way_round_turn_the_colors_and_not_the_numbers)
{
  LegendContent shown = content(ColorScale::RED_GREEN);
  shown.limits = {0.7f, 0.0f};
  const QImage picture = drawLegend(shown, LEGEND_HEIGHT);
  const Bar bar = findBar(picture);
  EXPECT_EQ(toRgb(picture.pixel(BAR_MIDDLE, bar.top)), (Rgb{0, 255, 0}));
  EXPECT_EQ(toRgb(picture.pixel(BAR_MIDDLE, bar.bottom)), (Rgb{255, 0, 0}));
  // All else is as it was: the same ticks with the same numbers.
  const QImage forwards = drawLegend(content(ColorScale::RED_GREEN), LEGEND_HEIGHT);
  ASSERT_EQ(picture.size(), forwards.size());
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = BAR_RIGHT + 2; x < picture.width(); ++x) {
      ASSERT_EQ(picture.pixel(x, y), forwards.pixel(x, y));
    }
  }
}

TEST_F(LegendTest, has_title_numbers_and_swatches)
{
  LegendContent shown = content();
  shown.coloring.lethal = {1, 2, 250, 255};
  shown.coloring.unknown = {3, 250, 4, 255};
  shown.coloring.below = {250, 5, 6, 255};
  shown.coloring.above = {7, 250, 250, 255};
  const auto hasColor = [&](const QImage& picture, const Rgba8& color) {
    int count = 0;
    for (int y = 0; y < picture.height(); ++y) {
      count += toRgb(picture.pixel(BAR_MIDDLE + 4, y)) == toRgb(color);
    }
    return count >= 9;
  };
  QImage picture = drawLegend(shown, LEGEND_HEIGHT);
  EXPECT_TRUE(hasColor(picture, shown.coloring.lethal));
  EXPECT_TRUE(hasColor(picture, shown.coloring.unknown));
  EXPECT_FALSE(hasColor(picture, shown.coloring.below));
  shown.coloring.mark_outside = true;
  picture = drawLegend(shown, LEGEND_HEIGHT);
  EXPECT_TRUE(hasColor(picture, shown.coloring.below));
  EXPECT_TRUE(hasColor(picture, shown.coloring.above));
  const Bar bar = findBar(picture);
  const int width = picture.width();
  EXPECT_GT(whitePixels(picture, QRect(0, 0, width, bar.top - 5)), 40);
  EXPECT_GT(whitePixels(picture, QRect(BAR_RIGHT + 2, bar.top, width, bar.bottom)), 60);
  EXPECT_GT(whitePixels(picture, QRect(BAR_RIGHT + 2, bar.bottom + 5, width, 60)), 40);
}

TEST_F(LegendTest, survives_odd_contents)
{
  const float greatest = std::numeric_limits<float>::max();
  for (const CostLimits& limits :
       {CostLimits{0, 0}, CostLimits{-greatest, greatest}, CostLimits{1e-40f, 2e-40f},
        CostLimits{-7, -7}, CostLimits{1e-30f, 1e30f}}) {
    for (const bool logarithmic : {false, true}) {
      for (const char* layer : {"", "a", "höhe",
                                "a layer whose name is longer than any screen is "
                                "wide, and no line break in it"}) {
        LegendContent shown{layer, layer, CostColoring(), limits};
        shown.coloring.logarithmic = logarithmic;
        for (const int height : {1, 60, 120, 1000}) {
          const QImage picture = drawLegend(shown, height, height == 60 ? 2.0 : 1.0);
          EXPECT_EQ(picture.height(), height == 60 ? 120 : height);
          EXPECT_LE(picture.width(), 400);
          EXPECT_GE(picture.width(), 20);
        }
      }
    }
  }
}

TEST_F(LegendTest, stands_at_the_right_of_the_view)
{
  const auto before = counts();
  {
    Legend legend;
    show(legend, content(ColorScale::VIRIDIS));
    const Image image = grab();
    const QImage picture = drawLegend(content(ColorScale::VIRIDIS), LEGEND_HEIGHT);
    EXPECT_EQ(differences(image, picture, DISTANCE), 0);
    EXPECT_EQ(legend.error(), "");
    // Nothing else has changed.
    EXPECT_GE(image.count({48, 48, 48}),
              static_cast<std::size_t>(640 * 480 - picture.width() * picture.height()));
    legend.hide();
    EXPECT_EQ(grab().count({48, 48, 48}), 640u * 480u);
    EXPECT_EQ(counts(), before);
    show(legend, content());
    EXPECT_EQ(differences(grab(), drawLegend(content(), LEGEND_HEIGHT), DISTANCE), 0);
  }
  EXPECT_EQ(grab().count({48, 48, 48}), 640u * 480u);
  EXPECT_EQ(counts(), before);
}

TEST_F(LegendTest, follows_its_content)
{
  Legend legend;
  for (LegendContent shown : {content(), content(ColorScale::MAGMA), content(ColorScale::GREY)}) {
    for (const char* layer : {"a", "a much longer name"}) {
      shown.layer = layer;
      show(legend, shown);
      EXPECT_EQ(differences(grab(), drawLegend(shown, LEGEND_HEIGHT), DISTANCE), 0) << layer;
    }
    shown.limits = {2.0f, 9.0f};
    show(legend, shown);
    show(legend, shown);
    EXPECT_EQ(differences(grab(), drawLegend(shown, LEGEND_HEIGHT), DISTANCE), 0);
  }
}

TEST_F(LegendTest, several_stand_side_by_side_and_close_up)
{
  const LegendContent first = content(ColorScale::PLASMA);
  LegendContent second = content(ColorScale::TURBO);
  second.layer = "roughness";
  const QImage first_picture = drawLegend(first, LEGEND_HEIGHT);
  const QImage second_picture = drawLegend(second, LEGEND_HEIGHT);
  Legend legend;
  Legend other;
  show(legend, first);
  show(other, second);
  const Image image = grab();
  EXPECT_EQ(differences(image, first_picture, DISTANCE), 0);
  EXPECT_EQ(differences(image, second_picture, 2 * DISTANCE + first_picture.width()), 0);
  legend.hide();
  EXPECT_EQ(differences(grab(), second_picture, DISTANCE), 0);
}

TEST_F(LegendTest, follows_the_size_of_the_view)
{
  Legend legend;
  show(legend, content());
  const QImage picture = drawLegend(content(), LEGEND_HEIGHT);
  EXPECT_EQ(differences(grab(), picture, DISTANCE), 0);
  for (const auto& size : {std::make_pair(800, 600), std::make_pair(300, 400)}) {
    resizePanel(size.first, size.second);
    grab();
    EXPECT_EQ(differences(grab(), picture, DISTANCE), 0) << size.first;
  }
  resizePanel(400, 200);  // lower than the legend: it shrinks
  grab();
  EXPECT_EQ(differences(grab(), drawLegend(content(), 200 - 2 * DISTANCE), DISTANCE), 0);
  resizePanel(400, 100);  // no room
  grab();
  EXPECT_EQ(grab().count({48, 48, 48}), 400u * 100u);
  EXPECT_EQ(legend.error(), "the 3D view is too small for it");
  resizePanel(640, 480);
  grab();
  EXPECT_EQ(differences(grab(), picture, DISTANCE), 0);
  EXPECT_EQ(legend.error(), "");
  Legend second;  // beside the first there is no room for it
  show(second, content());
  resizePanel(picture.width() + 40, 480);
  grab();
  EXPECT_EQ(differences(grab(), picture, DISTANCE), 0);
  EXPECT_EQ(legend.error(), "");
  EXPECT_EQ(second.error(), "the 3D view is too small for it");
  resizePanel(640, 480);
}

TEST_F(LegendTest, is_readable_on_white_and_on_black)
{
  Legend legend;
  show(legend, content());
  const QImage picture = drawLegend(content(), LEGEND_HEIGHT);
  rviz::Property* background =
      manager()->getRootDisplayGroup()->subProp("Global Options")->subProp("Background Color");
  const QVariant before = background->getValue();
  for (const Rgb& color : {Rgb{255, 255, 255}, Rgb{0, 0, 0}}) {
    background->setValue(QColor(color.red, color.green, color.blue));
    grab();
    const Image image = grab();
    EXPECT_EQ(differences(image, picture, DISTANCE, color), 0);
    // White text (255) on what is behind it.
    const Rgb behind = image.at(640 - DISTANCE - 3, 240);
    EXPECT_LE(behind.green, 95);
  }
  background->setValue(before);
}

TEST_F(LegendTest, is_nothing_to_be_selected)
{
  Legend legend;
  show(legend, content());
  grab();
  Ogre::Vector3 hit;
  EXPECT_FALSE(manager()->getSelectionManager()->get3DPoint(panel()->getViewport(), 600, 240, hit));
  EXPECT_EQ(differences(grab(), drawLegend(content(), LEGEND_HEIGHT), DISTANCE), 0);
}

TEST_F(LegendTest, a_thousand_of_them_leave_nothing)
{
  grab();
  const auto before = counts();
  for (int i = 0; i < 1000; ++i) {
    Legend legend;
    show(legend, content());
    if (i % 50 == 0) {
      spinFrames(1);
    }
  }
  spinFrames(2);
  EXPECT_EQ(counts(), before);
}
