// The labels of a TexturedMesh, in their own colors.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sources/mesh_source.h"
#include "support/label_display_fixture.h"
#include "support/label_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::Rgb;
using rviz_mesh_plugin::TexturedMeshDisplay;
using test_labels::colorOf;
using test_labels::ROW;
using test_labels::rows;

namespace {

const Rgb OWN{10, 20, 30};
const Rgb OTHER{200, 30, 90};

}  // namespace

class MeshLabelsTest : public LabelDisplayFixture
{
 protected:
  TexturedMeshDisplay* createMesh()
  {
    auto* display = createMeshDisplay();
    set(display, {"Show Labels", "Labels Topic"}, (name_space + "/new_cluster_label").c_str());
    server->addLabel("tree_1", rows(10, 0, 2));
    server->addLabel("tree_2", rows(10, 3, 4));
    publishMesh();
    EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "200 faces"));
    return display;
  }

  testing::AssertionResult seen(const Rgb& color, std::size_t row_count)
  {
    std::size_t pixels = 0;
    const auto matches = [&] {
      pixels = picture().count(color);
      return pixels == row_count * ROW;
    };
    if (spinUntil(matches, TIMEOUT)) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << pixels << " pixels are " << color;
  }
};

TEST_F(MeshLabelsTest, a_label_is_drawn_in_its_own_color_and_without_one_in_that_of_its_class)
{
  server->setColors(colorsOf({{"tree_2", OWN}}));
  auto* display = createMesh();
  spin(200);
  EXPECT_TRUE(server->colorsAsked().empty()) << "labels are not shown";
  EXPECT_EQ(server->colors.getNumSubscribers(), 0u);
  set(display, {"Show Labels"}, true);
  EXPECT_TRUE(seen(OWN, 1));
  EXPECT_TRUE(seen(colorOf("tree"), 2));
  EXPECT_EQ(server->colorsAsked(), std::vector<std::string>{"mesh"});

  server->colors.publish(colorsOf({{"tree_2", OTHER}}));
  EXPECT_TRUE(seen(OTHER, 1)) << "another color";
  EXPECT_EQ(picture().count(colorOf("tree")), 2 * ROW);
  server->colors.publish(colorsOf({{"tree_1", OWN}, {"tree_2", OTHER}}));
  EXPECT_TRUE(seen(OWN, 2)) << "a second one";
  EXPECT_EQ(picture().count(OTHER), ROW);
  server->colors.publish(colorsOf({{"tree_1", OWN}}));
  EXPECT_TRUE(seen(colorOf("tree"), 1)) << "taken away";
  server->labels.publish(LabelServer::cluster("tree_1", rows(10, 0, 3)));
  EXPECT_TRUE(seen(OWN, 3)) << "with more faces";
  EXPECT_EQ(server->colorsAsked().size(), 1u);
}

TEST_F(MeshLabelsTest, colors_are_followed_while_labels_are_shown_and_known_until_they_are_again)
{
  server->setColors(colorsOf({{"tree_2", OWN}}));
  auto* display = createMesh();
  set(display, {"Show Labels"}, true);
  EXPECT_TRUE(seen(OWN, 1));
  set(display, {"Show Labels"}, false);
  EXPECT_TRUE(seen(OWN, 0));
  EXPECT_TRUE(spinUntil([&] { return server->colors.getNumSubscribers() == 0; }));
  server->setColors(colorsOf({{"tree_1", OTHER}, {"tree_2", OWN}}));
  set(display, {"Show Labels"}, true);
  EXPECT_TRUE(seen(OTHER, 2)) << "asked again";
  EXPECT_EQ(picture().count(OWN), ROW);
  display->setEnabled(false);
  EXPECT_TRUE(spinUntil([&] { return server->colors.getNumSubscribers() == 0; }));
  display->setEnabled(true);
  EXPECT_TRUE(spinUntil([&] { return server->colors.getNumSubscribers() == 1; }));
  server->colors.publish(colorsOf({}));
  EXPECT_TRUE(seen(colorOf("tree"), 3));
  display->reset();
  server->colors.publish(colorsOf({{"tree_1", OWN}}));
  EXPECT_TRUE(seen(OWN, 2)) << "after a reset";
}

TEST_F(MeshLabelsTest, below_another_display_the_colors_are_those_of_its_services)
{
  server->addLabel("tree_1", rows(10, 0, 2));
  server->setColors(colorsOf({{"tree_1", OWN}, {"wall_1", OTHER}}));
  auto* display = createMeshDisplay();
  rviz_mesh_plugin::MeshSource source;
  source.geometry_topic = geometry_topic;
  source.service_namespace = name_space;
  display->setSource(source);
  set(display, {"Show Labels"}, true);
  publishMesh();
  EXPECT_TRUE(seen(OWN, 2));
}

TEST_F(MeshLabelsTest, a_display_of_labels_asks_for_their_colors_as_well)
{
  server->addLabel("tree_1", rows(10, 0, 2));
  server->setColors(colorsOf({{"tree_1", OWN}}));
  createLabels();
  publishMesh();
  EXPECT_TRUE(seen(OWN, 2));
  EXPECT_EQ(server->colorsAsked(), std::vector<std::string>{"mesh"});
}
