#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/display_fixture.h"

namespace {

mesh_msgs::MeshGeometryStamped grid(std::uint32_t cells)
{
  return test_meshes::terrain(cells, [](double x, double y) { return 0.1 * x * y; });
}

std::vector<float> ramp(std::size_t count)
{
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = static_cast<float>(i);
  }
  return values;
}

}  // namespace

class SceneTest : public DisplayFixture
{
 protected:
  /// Counts an empty scene, after the programs that all meshes share exist.
  void SetUp() override
  {
    DisplayFixture::SetUp();
    auto* warm_up = createMeshDisplay();
    ASSERT_TRUE(show(warm_up, grid(1)));
    warm_up->setEnabled(false);
    delete warm_up;
    // What it latched would be the first mesh of the test's own display.
    geometry.shutdown();
    geometry = node.advertise<mesh_msgs::MeshGeometryStamped>(geometry_topic, 100, true);
    spinFrames();
    empty = counts();
  }

  /// A display that has its own scene node and nothing else.
  osmesa_harness::SceneCounts withEmptyDisplay() const
  {
    auto one_more = empty;
    ++one_more.nodes;
    return one_more;
  }

  osmesa_harness::SceneCounts empty;
};

TEST_F(SceneTest, one_mesh_takes_no_more_memory_than_it_has_to)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(200)));
  spinFrames();
  const auto shown = counts();
  EXPECT_EQ(shown.textures, empty.textures);
  EXPECT_EQ(shown.gpu_programs, empty.gpu_programs);
  // Position and normal; three indices, and at most half as much again for
  // levels of detail.
  EXPECT_GE(shown.vertex_buffer_bytes, empty.vertex_buffer_bytes + 24 * 201 * 201);
  EXPECT_LE(shown.vertex_buffer_bytes, empty.vertex_buffer_bytes + 36 * 201 * 201);
  EXPECT_GE(shown.index_buffer_bytes, empty.index_buffer_bytes + 12 * 2 * 200 * 200);
  EXPECT_LE(shown.index_buffer_bytes, empty.index_buffer_bytes + 18 * 2 * 200 * 200);
}

TEST_F(SceneTest, a_layer_switch_uploads_colors_only)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(20)));
  spinFrames();
  const auto before = counts();
  costs.publish(test_meshes::costs("a", ramp(441)));
  costs.publish(test_meshes::costs("b", std::vector<float>(441, 1.0f)));
  set(display, {"Display Type"}, "Vertex Costs");
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'")) << "the first";
  EXPECT_EQ(display->visual()->colorUploads(), 1u);
  set(display, {"Display Type", "Vertex Costs Type"}, "-- None --");
  EXPECT_TRUE(waitForStatus(display, "Costs", "Warn", "one of 'a', 'b'"));
  for (std::size_t i = 0; i < 10; ++i) {
    set(display, {"Display Type", "Vertex Costs Type"}, i % 2 == 0 ? "a" : "b");
    EXPECT_EQ(display->visual()->colorUploads(), i + 2);
  }
  EXPECT_EQ(display->visual()->geometryUploads(), 1u);
  spinFrames();
  const auto after = counts();
  EXPECT_GE(after.vertex_buffer_bytes, before.vertex_buffer_bytes + 4 * 441);
  EXPECT_LE(after.vertex_buffer_bytes, before.vertex_buffer_bytes + 8 * 441);
  EXPECT_EQ(after.index_buffer_bytes, before.index_buffer_bytes);
  set(display, {"Display Type"}, "Fixed Color");
  EXPECT_EQ(counts(), before) << "the buffer of the colors is freed";
}

TEST_F(SceneTest, a_change_of_style_uploads_nothing)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(20)));
  colors.publish(
      test_meshes::colors(std::vector<std_msgs::ColorRGBA>(441, test_meshes::color(1, 0, 0))));
  set(display, {"Display Type"}, "Vertex Color");
  ASSERT_TRUE(waitForStatus(display, "Colors", "Ok", "441 colors"));
  const std::size_t color_uploads = display->visual()->colorUploads();
  const auto before = counts();
  set(display, {"Show Wireframe"}, true);
  set(display, {"Show Wireframe", "Wireframe Alpha"}, 0.5f);
  set(display, {"Show Wireframe", "Wireframe Color"}, QColor(1, 2, 3));
  set(display, {"Display Type", "Faces Alpha"}, 0.5f);
  spinFrames();
  EXPECT_EQ(display->visual()->geometryUploads(), 1u);
  EXPECT_EQ(display->visual()->colorUploads(), color_uploads);
  EXPECT_EQ(counts(), before);
}

TEST_F(SceneTest, normals_are_built_only_while_shown)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(20)));
  const auto before = counts();
  set(display, {"Show Normals"}, true);
  const auto shown = counts();
  EXPECT_EQ(shown.vertex_buffer_bytes, before.vertex_buffer_bytes + 2 * 12 * 441);
  set(display, {"Show Normals", "Normals Scaling Factor"}, 0.5f);
  set(display, {"Show Normals", "Normals Alpha"}, 0.5f);
  EXPECT_EQ(counts(), shown);
  set(display, {"Show Normals"}, false);
  EXPECT_EQ(counts(), before);
}

TEST_F(SceneTest, normals_of_a_large_mesh_are_thinned_out)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(400)));
  const auto before = counts();
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "normals computed, uuid"));
  set(display, {"Show Normals"}, true);
  const std::size_t lines = (401 * 401 + 1) / 2;
  EXPECT_EQ(counts().vertex_buffer_bytes, before.vertex_buffer_bytes + 2 * 12 * lines);
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "normals computed (one in 2 is drawn)"));
}

TEST_F(SceneTest, only_the_colors_that_are_shown_are_uploaded)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  ASSERT_TRUE(show(display, grid(20)));
  costs.publish(test_meshes::costs("a", ramp(441)));
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'"));
  EXPECT_EQ(display->visual()->colorUploads(), 1u);
  costs.publish(test_meshes::costs("a", ramp(441), "another mesh"));
  costs.publish(test_meshes::costs("b", ramp(441)));
  colors.publish(
      test_meshes::colors(std::vector<std_msgs::ColorRGBA>(441, test_meshes::color(1, 0, 0))));
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'"));
  ASSERT_TRUE(waitForStatus(display, "Colors", "Ok", "441 colors"));
  EXPECT_EQ(display->visual()->colorUploads(), 1u);
}

TEST_F(SceneTest, nothing_grows_with_updates_and_nothing_is_left_after_reset_disable_and_removal)
{
  auto* display = createMeshDisplay();
  set(display, {"Show Wireframe"}, true);
  set(display, {"Show Normals"}, true);
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  ASSERT_TRUE(show(display, grid(10)));
  costs.publish(test_meshes::costs("a", ramp(121)));
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'"));
  spinFrames();
  const auto shown = counts();
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(show(display, grid(5 + i)));
  }
  ASSERT_TRUE(show(display, grid(10)));
  spinFrames();
  EXPECT_EQ(counts(), shown) << "after updates of other sizes";
  for (int i = 0; i < 100; ++i) {
    display->setEnabled(false);
    ASSERT_TRUE(display->visual()) << "the data are kept";
    ASSERT_TRUE(display->shownMeshes().empty());
    spin(i % 10);
    display->setEnabled(true);
    ASSERT_TRUE(display->visual());
    spin(i % 10);
  }
  spinFrames();
  EXPECT_EQ(counts(), shown) << "enabled again";
  geometry.shutdown();  // no latched mesh comes back
  costs.shutdown();
  for (int i = 0; i < 100; ++i) {
    display->reset();
    ASSERT_FALSE(display->visual());
    spin(i % 10);
  }
  spinFrames();
  EXPECT_EQ(counts(), withEmptyDisplay()) << "after reset";
  delete display;
  EXPECT_EQ(counts(), empty) << "after removal";
}

TEST_F(SceneTest, reset_gets_the_latched_mesh_again)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(10)));
  const auto shown = counts();
  display->reset();
  ASSERT_TRUE(spinUntil([&] { return display->mesh() != nullptr; })) << status(display, "Topic");
  spinFrames();
  EXPECT_EQ(counts(), shown);
}

TEST_F(SceneTest, enabling_shows_the_kept_mesh_without_any_publisher)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(10)));
  spinFrames();
  const auto shown = counts();
  geometry.shutdown();
  display->setEnabled(false);
  spinFrames();
  EXPECT_EQ(status(display, "Geometry"), "");
  display->setEnabled(true);
  spinFrames();
  EXPECT_EQ(counts(), shown);
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "121 vertices, 200 faces"));
}

TEST_F(SceneTest, another_topic_takes_the_mesh_away)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(10)));
  set(display, {"Geometry Topic"}, "/nobody/publishes/this");
  EXPECT_TRUE(spinUntil([&] { return !display->visual(); }));
  EXPECT_TRUE(
      waitForStatus(display, "Topic", "Warn", "no message received on /nobody/publishes/this yet"));
  EXPECT_EQ(status(display, "Geometry"), "");
  EXPECT_EQ(counts(), withEmptyDisplay());
  set(display, {"Geometry Topic"}, "not a name");
  EXPECT_TRUE(waitForStatus(display, "Topic", "Error", "cannot subscribe to 'not a name'"));
  set(display, {"Geometry Topic"}, "");
  EXPECT_TRUE(waitForStatus(display, "Topic", "Warn", "no topic chosen"));
}

TEST_F(SceneTest, two_displays_of_one_topic_do_not_disturb_each_other)
{
  auto* first = createMeshDisplay();
  auto* second = createMeshDisplay("rviz_map_plugin/Mesh");
  ASSERT_TRUE(show(first, grid(10)));
  ASSERT_TRUE(spinUntil([&] { return second->mesh() != nullptr; }));
  EXPECT_EQ(first->mesh(), second->mesh()) << "one copy in memory";
  spinFrames();
  const auto both = counts();
  delete first;
  spinFrames();
  const auto one = counts();
  EXPECT_EQ(both.vertex_buffer_bytes - one.vertex_buffer_bytes,
            one.vertex_buffer_bytes - empty.vertex_buffer_bytes);
  EXPECT_TRUE(waitForStatus(second, "Geometry", "Ok", "121 vertices"));
}
