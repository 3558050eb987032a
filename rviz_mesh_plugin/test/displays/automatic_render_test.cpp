#include <memory>
#include <string>
#include <vector>

#include <QComboBox>
#include <QStyleOptionViewItem>

#include <gtest/gtest.h>
#include <rviz/config.h>
#include <rviz/properties/enum_property.h>

#include "support/display_fixture.h"

namespace {

const osmesa_harness::Rgb VIRIDIS_LOW{68, 1, 84}, VIRIDIS_HIGH{253, 231, 37};

double slope(double x, double)
{
  return 0.5 * x;
}

}  // namespace

/// What a display shows that somebody has just added.
class AutomaticTest : public DisplayFixture
{
 protected:
  Display* add()
  {
    auto* display = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh");
    set(display, {"Display Type", "Legend"}, false);
    set(display, {"Display Type", "Vertex Costs Topic"}, costs_topic.c_str());
    set(display, {"Display Type", "Vertex Colors Topic"}, colors_topic.c_str());
    set(display, {"Geometry Topic"}, geometry_topic.c_str());
    spinFrames(1);
    return display;
  }

  static std::string valueOf(Display* display, const std::vector<const char*>& path)
  {
    return find(display, path)->getValue().toString().toStdString();
  }

  /// Waits until a list of choices has this one.
  static bool offers(Display* display, const std::vector<const char*>& path, const char* choice)
  {
    return spinUntil([&] {
      const QStyleOptionViewItem option;
      auto* list = dynamic_cast<rviz::EnumProperty*>(find(display, path));
      const std::unique_ptr<QWidget> editor(list->createEditor(nullptr, option));
      return dynamic_cast<const QComboBox&>(*editor).findText(choice) >= 0;
    });
  }

  /// Of points at both ends of the slope: from above, 100 pixels a meter.
  static testing::AssertionResult shows(const osmesa_harness::Rgb& low,
                                        const osmesa_harness::Rgb& high)
  {
    osmesa_harness::Rgb left, right;
    for (int i = 0; i < 100; ++i) {
      viewFromAbove(0.0, 0.0, 100.0);
      spinFrames(3);
      const osmesa_harness::Image image = grab();
      left = image.at(224, 240);
      right = image.at(416, 240);
      if (osmesa_harness::isNear(left, low, 40) && osmesa_harness::isNear(right, high, 40)) {
        return testing::AssertionSuccess();
      }
    }
    return testing::AssertionFailure() << left << " and " << right;
  }
};

TEST_F(AutomaticTest, the_best_that_the_map_has_is_shown_without_lines)
{
  auto* display = add();
  EXPECT_EQ(valueOf(display, {"Display Type"}), "Automatic");
  EXPECT_EQ(valueOf(display, {"Show Wireframe"}), "false");
  EXPECT_EQ(valueOf(display, {"Show Normals"}), "false");
  ASSERT_TRUE(show(display, test_meshes::terrain(8, slope)));
  EXPECT_TRUE(shows(VIRIDIS_LOW, VIRIDIS_HIGH)) << "heights";
  // Falling along x, so the other way round.
  std::vector<float> values;
  for (int i = 0; i < 81; ++i) {
    values.push_back(static_cast<float>(8 - i % 9));
  }
  costs.publish(test_meshes::costs("height_diff", values));
  EXPECT_TRUE(shows(VIRIDIS_HIGH, VIRIDIS_LOW)) << "the only layer";
  EXPECT_EQ(valueOf(display, {"Display Type", "Vertex Costs Type"}), "height_diff");
  costs.publish(test_meshes::costs("Combined Costs", std::vector<float>(81, 1.0f)));
  EXPECT_TRUE(shows(VIRIDIS_LOW, VIRIDIS_LOW));
  EXPECT_EQ(valueOf(display, {"Display Type", "Vertex Costs Type"}), "Combined Costs");
  colors.publish(
      test_meshes::colors(std::vector<std_msgs::ColorRGBA>(81, test_meshes::color(0, 0, 1))));
  EXPECT_TRUE(shows({0, 0, 255}, {0, 0, 255}));
  EXPECT_EQ(valueOf(display, {"Display Type"}), "Automatic");
}

/// As those of a map without layers.
TEST_F(AutomaticTest, costs_of_0_alone_are_not_shown_before_others_were)
{
  auto* display = add();
  ASSERT_TRUE(show(display, test_meshes::terrain(8, slope)));
  const std::vector<float> all_free(81, 0.0f);
  costs.publish(test_meshes::costs("Combined Costs", all_free));
  ASSERT_TRUE(offers(display, {"Display Type", "Vertex Costs Type"}, "Combined Costs"));
  EXPECT_TRUE(shows(VIRIDIS_LOW, VIRIDIS_HIGH)) << "heights tell more";
  costs.publish(test_meshes::costs("Combined Costs", std::vector<float>(81, 1.0f)));
  EXPECT_TRUE(shows(VIRIDIS_LOW, VIRIDIS_LOW));
  costs.publish(test_meshes::costs("Combined Costs", all_free));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "from 0 to 0"));
  EXPECT_TRUE(shows(VIRIDIS_LOW, VIRIDIS_LOW));
  auto other = test_meshes::terrain(8, slope);
  other.uuid = "other";
  auto its_costs = test_meshes::costs("Combined Costs", all_free);
  its_costs.uuid = other.uuid;
  ASSERT_TRUE(show(display, other));
  costs.publish(its_costs);
  EXPECT_TRUE(shows(VIRIDIS_LOW, VIRIDIS_HIGH)) << "what was told of another mesh";
}

TEST_F(AutomaticTest, what_the_user_looks_at_stays)
{
  auto* display = add();
  ASSERT_TRUE(show(display, test_meshes::terrain(8, slope)));
  costs.publish(test_meshes::costs("Combined Costs", std::vector<float>(81, 1.0f)));
  costs.publish(test_meshes::costs("height_diff", std::vector<float>(81, 1.0f)));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'Combined Costs'"));
  EXPECT_EQ(valueOf(display, {"Display Type"}), "Automatic");
  set(display, {"Display Type", "Vertex Costs Type"}, "height_diff");
  EXPECT_EQ(valueOf(display, {"Display Type"}), "Vertex Costs");
  colors.publish(
      test_meshes::colors(std::vector<std_msgs::ColorRGBA>(81, test_meshes::color(0, 0, 1))));
  costs.publish(test_meshes::costs("Combined Costs", std::vector<float>(81, 2.0f)));
  spin(300);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'height_diff'"));
}

TEST_F(AutomaticTest, files_and_released_names_begin_as_ever)
{
  auto* released = createDisplayAs<Display>("rviz_map_plugin/Mesh");
  auto* loaded = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh");
  loaded->load(rviz::Config());
  for (Display* display : {released, loaded}) {
    EXPECT_EQ(valueOf(display, {"Display Type"}), "Fixed Color");
    EXPECT_EQ(valueOf(display, {"Display Type", "Faces Color"}), "0; 255; 0");
    EXPECT_EQ(valueOf(display, {"Display Type", "Color Scale"}), "Rainbow");
    EXPECT_EQ(valueOf(display, {"Show Wireframe"}), "true");
    EXPECT_EQ(valueOf(display, {"Show Normals"}), "true");
  }
}

TEST_F(AutomaticTest, vertex_costs_open_with_a_layer_unless_a_file_says_none)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  costs.publish(test_meshes::costs("steepness", {0, 0, 1, 1}));
  set(display, {"Display Type"}, "Vertex Costs");
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'steepness'"));
  set(display, {"Display Type", "Vertex Costs Type"}, "-- None --");
  costs.publish(test_meshes::costs("ridge", {0, 0, 1, 1}));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Warn", "ridge"));
  EXPECT_EQ(valueOf(display, {"Display Type", "Vertex Costs Type"}), "-- None --");

  rviz::Config config;
  rviz::Config type = config.mapMakeChild("Display Type");
  type.mapSetValue("Value", "Vertex Costs");
  auto* loaded = createMeshDisplay();
  loaded->load(config);
  set(loaded, {"Geometry Topic"}, geometry_topic.c_str());
  set(loaded, {"Display Type", "Vertex Costs Topic"}, costs_topic.c_str());
  EXPECT_TRUE(waitForStatus(loaded, "Costs", "Warn", "ridge"));
  EXPECT_EQ(valueOf(loaded, {"Display Type", "Vertex Costs Type"}), "-- None --");
}

TEST_F(AutomaticTest, heights_have_limits_and_lines)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::terrain(8, slope)));
  set(display, {"Display Type"}, "Height");
  set(display, {"Display Type", "Color Scale"}, "Red Green");
  EXPECT_TRUE(shows({0, 255, 0}, {255, 0, 0}));
  set(display, {"Display Type", "Use Custom limits"}, true);
  set(display, {"Display Type", "Use Custom limits", "Vertex Costs Lower Limit"}, 10.0f);
  set(display, {"Display Type", "Use Custom limits", "Vertex Costs Upper Limit"}, 20.0f);
  EXPECT_TRUE(shows({0, 255, 0}, {0, 255, 0}));
  set(display, {"Display Type"}, "Contour Lines");
  set(display, {"Display Type", "Contour Interval"}, 0.25f);
  spinFrames(3);
  viewFromAbove(0.0, 0.0, 100.0);
  spinFrames(3);
  const osmesa_harness::Image image = grab();
  for (const int x : {270, 320, 370}) {  // at -0.25, 0 and 0.25
    EXPECT_LT(image.at(x, 230).green, 150) << x;
  }
  EXPECT_GT(image.at(345, 230).green, 200);
}
