// RViz's own displays, pixel by pixel.
#include <osmesa_harness/render_fixture.h>

#include <rviz/display.h>
#include <rviz/display_group.h>
#include <rviz/properties/property.h>
#include <rviz/visualization_manager.h>

#include <cstdlib>

#include <QColor>
#include <QGuiApplication>

using osmesa_harness::Image;
using osmesa_harness::Rgb;

namespace {

const Rgb BACKGROUND{48, 48, 48};
const Rgb RED{255, 0, 0};

class Displays : public osmesa_harness::RenderFixture
{
 protected:
  // Lines 10 cm wide, one each meter: pixels in their middle have their color exactly.
  static rviz::Display* createGrid()
  {
    rviz::Display* grid = createDisplay("rviz/Grid");
    grid->subProp("Line Style")->setValue("Billboards");
    grid->subProp("Line Style")->subProp("Line Width")->setValue(0.1);
    grid->subProp("Color")->setValue(QColor(255, 0, 0));
    grid->subProp("Alpha")->setValue(1.0);
    return grid;
  }
};

TEST_F(Displays, an_empty_scene_is_background)
{
  const Image image = grab();
  EXPECT_EQ(image, Image(DEFAULT_WIDTH, DEFAULT_HEIGHT, BACKGROUND));
}

TEST_F(Displays, a_grid_has_lines_where_they_belong)
{
  createGrid();
  const Image image = grab();

  for (int x = -3; x <= 3; ++x) {
    for (int y = -2; y <= 1; ++y) {
      // 100 pixels a meter, y up; (50, 50) beside a crossing lies inside a cell.
      EXPECT_EQ(image.at(320 + 100 * x, 240 - 100 * y - 50), RED) << x << ", " << y;
      if (x < 3) {
        EXPECT_EQ(image.at(320 + 100 * x + 50, 240 - 100 * y - 50), BACKGROUND) << x << ", " << y;
      }
    }
  }
  // Seven upright and five level lines 10 pixels wide, less what they share at their crossings.
  constexpr std::size_t EXPECTED = 7 * 10 * 480 + 5 * 10 * 640 - 7 * 5 * 10 * 10;
  EXPECT_NEAR(double(image.count(RED)), double(EXPECTED), 0.01 * EXPECTED);
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("grid", image));
}

TEST_F(Displays, the_view_from_above_is_placed_and_scaled)
{
  createGrid();
  viewFromAbove(0.5, 0.25, 200.0);
  const Image image = grab();

  // The line x = 1 m lies 100 pixels right of the middle, y = 0 lies 50 pixels below it.
  EXPECT_EQ(image.at(420, 150), RED);
  EXPECT_EQ(image.at(320, 290), RED);
  EXPECT_EQ(image.center(), BACKGROUND);
}

TEST_F(Displays, axes_are_seen_from_any_side)
{
  rviz::Display* axes = createDisplay("rviz/Axes");
  axes->subProp("Length")->setValue(1.0);
  axes->subProp("Radius")->setValue(0.1);

  const Image above = grab();
  const Rgb x_axis = above.at(370, 240);
  const Rgb y_axis = above.at(320, 190);
  EXPECT_GT(x_axis.red, 100);
  EXPECT_EQ(x_axis.green, 0);
  EXPECT_GT(y_axis.green, 100);
  EXPECT_EQ(y_axis.red, 0);

  // From the front, y points to the right and z up.
  lookAt({5.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
  const Image front = grab();
  EXPECT_GT(front.at(360, 240).green, front.at(360, 240).blue + 50);
  EXPECT_GT(front.at(320, 200).blue, front.at(320, 200).green + 50);

  lookAt({3.0, -2.0, 1.5}, {0.0, 0.0, 0.5});
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("axes_free_view", grab()));
}

TEST_F(Displays, a_disabled_display_is_not_drawn)
{
  rviz::Display* grid = createGrid();
  EXPECT_GT(grab().count(RED), 0u);
  grid->setEnabled(false);
  EXPECT_EQ(grab(), Image(DEFAULT_WIDTH, DEFAULT_HEIGHT, BACKGROUND));
}

TEST_F(Displays, each_test_starts_anew)
{
  EXPECT_EQ(manager()->getRootDisplayGroup()->numDisplays(), 0);
  EXPECT_EQ(grab(), Image(DEFAULT_WIDTH, DEFAULT_HEIGHT, BACKGROUND));
}

TEST_F(Displays, an_unknown_class_is_refused_with_its_name)
{
  try {
    createDisplay("rviz/NoSuchDisplay");
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("rviz/NoSuchDisplay"), std::string::npos)
        << error.what();
  }
}

TEST_F(Displays, an_eye_in_its_target_is_refused)
{
  EXPECT_THROW(lookAt({1.0, 2.0, 3.0}, {1.0, 2.0, 3.0}), std::invalid_argument);
}

TEST_F(Displays, spinning_ends_at_its_time_limit)
{
  EXPECT_FALSE(spinUntil([] { return false; }, 50));
  EXPECT_TRUE(spinUntil([] { return true; }, 0));
}

TEST_F(Displays, settings_of_the_build_file_arrive)
{
  const char* setting = std::getenv("OSMESA_HARNESS_TEST_SETTING");
  if (!setting) {
    GTEST_SKIP() << "started by hand";
  }
  EXPECT_STREQ(setting, "arrived");
}

}  // namespace
