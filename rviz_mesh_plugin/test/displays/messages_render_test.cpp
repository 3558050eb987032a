#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <ros/duration.h>

#include "support/display_fixture.h"

namespace {

mesh_msgs::MeshGeometryStamped grid(std::uint32_t cells)
{
  return test_meshes::terrain(cells, [](double x, double y) { return 0.1 * x * y; });
}

}  // namespace

class MessagesTest : public DisplayFixture
{
};

TEST_F(MessagesTest, bad_geometry_is_refused_with_a_reason_and_makes_no_object)
{
  auto* display = createMeshDisplay();
  spinFrames();
  const auto empty = counts();
  struct Case
  {
    mesh_msgs::MeshGeometryStamped message;
    std::string reason;
  };
  std::vector<Case> cases(9, {grid(2), ""});
  cases[0].message.mesh_geometry.faces[5].vertex_indices[1] = 9;
  cases[0].reason = "face 5 refers to vertex 9, but the mesh has 9 vertices";
  cases[1].message.mesh_geometry.faces[0].vertex_indices[0] = 0xFFFFFFFF;
  cases[1].reason = "face 0 refers to vertex 4294967295";
  cases[2].message.mesh_geometry.vertices[3].z = std::numeric_limits<double>::quiet_NaN();
  cases[2].reason = "vertex 3 is";
  cases[3].message.mesh_geometry.vertices[8].x = 1e60;
  cases[3].reason = "vertex 8 is (1e+60";
  cases[4].message.mesh_geometry.vertices[0].y = 3e38;
  cases[4].reason = "too far to be drawn";
  cases[5].message.mesh_geometry.faces.clear();
  cases[5].reason = "no faces";
  cases[6].message = test_meshes::emptyMesh();
  cases[6].reason = "no vertices";
  cases[7].message.mesh_geometry.vertex_normals.resize(8);
  cases[7].reason = "there are 8 normals for 9 vertices";
  cases[8].message.header.frame_id.clear();
  cases[8].reason = "frame_id is empty";
  for (const Case& one : cases) {
    geometry.publish(one.message);
    EXPECT_TRUE(waitForStatus(display, "Geometry", "Error", one.reason));
    EXPECT_FALSE(display->visual());
  }
  EXPECT_EQ(counts(), empty);
  ASSERT_TRUE(show(display, grid(2)));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "9 vertices, 8 faces"));
  EXPECT_TRUE(
      waitForStatus(display, "Topic", "Ok", "10 messages received; 9 of 10 messages refused"));
  geometry.publish(cases[0].message);
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Error", "the mesh before it stays"));
  EXPECT_TRUE(display->visual());
}

TEST_F(MessagesTest, bad_costs_and_colors_are_refused_with_a_reason)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(1)));
  costs.publish(test_meshes::costs("a", {0, 0, -INFINITY, 0}));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Error", "the cost of vertex 2 is -inf"));
  colors.publish(test_meshes::colors({test_meshes::color(0, 0, 255)}));
  EXPECT_TRUE(waitForStatus(display, "Colors", "Error", "the color of vertex 0 is (0, 0, 255, 1)"));
  costs.publish(test_meshes::costs("a", {0, 0, 0}));
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  EXPECT_TRUE(
      waitForStatus(display, "Costs", "Error", "layer 'a': there are 3 costs for 4 vertices"));
  colors.publish(test_meshes::colors({test_meshes::color(0, 0, 1)}));
  set(display, {"Display Type"}, "Vertex Color");
  EXPECT_TRUE(waitForStatus(display, "Colors", "Error", "there are 1 colors for 4 vertices"));
  EXPECT_EQ(display->visual()->colorUploads(), 0u);
}

TEST_F(MessagesTest, costs_and_colors_before_their_geometry_are_applied_when_it_comes)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  costs.publish(test_meshes::costs("a", {0, 1, 2, 3}));
  costs.publish(test_meshes::costs("a", {5, 6, 7, 8}, "another mesh"));
  colors.publish(
      test_meshes::colors(std::vector<std_msgs::ColorRGBA>(4, test_meshes::color(1, 0, 0))));
  EXPECT_TRUE(
      waitForStatus(display, "Costs", "Ok", "2 layers wait for a geometry with their uuid"));
  EXPECT_TRUE(
      waitForStatus(display, "Colors", "Ok", "1 set of colors waits for a geometry with its uuid"));
  ASSERT_TRUE(show(display, grid(1)));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 4 costs from 0 to 3"));
  EXPECT_EQ(display->visual()->colorUploads(), 1u);
  set(display, {"Display Type"}, "Vertex Color");
  EXPECT_EQ(display->visual()->colorUploads(), 2u);
  EXPECT_TRUE(waitForStatus(display, "Colors", "Ok", "4 colors"));
  auto other = grid(1);
  other.uuid = "another mesh";
  set(display, {"Display Type"}, "Vertex Costs");
  ASSERT_TRUE(show(display, other));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 4 costs from 5 to 8"));
}

TEST_F(MessagesTest, no_empty_or_distorted_scene_is_said_to_be_all_right)
{
  auto* display = createMeshDisplay();
  auto point = grid(2);
  for (auto& vertex : point.mesh_geometry.vertices) {
    vertex = test_meshes::point(7, 0, 0);
  }
  ASSERT_TRUE(show(display, point));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Warn", "all 9 vertices lie in one point"));
  auto far = grid(2);
  for (auto& vertex : far.mesh_geometry.vertices) {
    vertex.x += 4e7;
  }
  ASSERT_TRUE(show(display, far));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Warn", "a tenth of the median edge (1.00499 m)"));
  auto named = grid(2);
  named.uuid = std::string(1000000, 'u');
  ASSERT_TRUE(show(display, named));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Warn", "the uuid has 1000000 characters"));
  costs.publish(test_meshes::costs("a", std::vector<float>(9, 1.0f), "another"));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Warn", "that is 'another', but 'uuu"));
  EXPECT_LT(status(display, "Costs").size() + status(display, "Geometry").size(), 2000u);
  ASSERT_TRUE(show(display, grid(2)));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "9 vertices, 8 faces"));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Warn", "that is 'another', but 'mesh' is shown"));
  costs.publish(test_meshes::costs("a", std::vector<float>(9, 1.0f)));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "1 layer: 'a'"));
}

TEST_F(MessagesTest, a_burst_of_layers_arrives_whole)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  ASSERT_TRUE(show(display, grid(1)));
  for (int i = 0; i < 30; ++i) {
    costs.publish(test_meshes::costs("layer " + std::to_string(i), {0, 1, 2, float(i)}));
  }
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'layer "));
  set(display, {"Display Type", "Vertex Costs Type"}, "-- None --");
  EXPECT_TRUE(waitForStatus(display, "Costs", "Warn", "'layer 28', 'layer 29'"));
  const std::size_t uploads = display->visual()->colorUploads();
  for (int i = 0; i < 30; ++i) {
    set(display, {"Display Type", "Vertex Costs Type"}, QString("layer %1").arg(i));
    EXPECT_EQ(display->visual()->colorUploads(), uploads + i + 1) << "layer " << i << " was lost";
  }
}

TEST_F(MessagesTest, textures_are_announced_as_missing)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, grid(1)));
  set(display, {"Display Type"}, "Textures");
  EXPECT_TRUE(waitForStatus(display, "Textures", "Warn", "set 'Materials Topic'"));
  set(display, {"Display Type"}, "Fixed Color");
  EXPECT_TRUE(spinUntil([&] { return status(display, "Textures").empty(); }));
}

TEST_F(MessagesTest, a_fast_stream_of_changing_sizes_with_malformed_messages_does_no_harm)
{
  auto* display = createMeshDisplay();
  set(display, {"Show Wireframe"}, true);
  set(display, {"Show Normals"}, true);
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  ASSERT_TRUE(show(display, grid(4)));
  costs.publish(test_meshes::costs("a", std::vector<float>(25, 1.0f)));
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'"));
  spinFrames();
  const auto before = counts();
  for (int i = 0; i < 100; ++i) {
    const std::uint32_t cells = 1 + 7 * (i % 5);
    auto message = grid(cells);
    if (i % 3 == 1) {
      message.mesh_geometry.faces.back().vertex_indices[2] = 0xFFFFFFFF;
    } else if (i % 7 == 2) {
      message.mesh_geometry.vertices.back().x = NAN;
    }
    geometry.publish(message);
    // Costs of the right and of the wrong length in turn.
    costs.publish(test_meshes::costs(
        "a", std::vector<float>(i % 2 ? 4 : (cells + 1) * (cells + 1), float(i))));
    spin(20);
  }
  ASSERT_TRUE(show(display, grid(4)));
  costs.publish(test_meshes::costs("a", std::vector<float>(25, 2.0f)));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 25 costs from 2 to 2"));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "25 vertices, 32 faces"));
  EXPECT_TRUE(waitForStatus(display, "Topic", "Ok", "refused"));
  spinFrames();
  EXPECT_EQ(counts(), before);
}

TEST_F(MessagesTest, removal_in_the_middle_of_a_stream_does_no_harm)
{
  const auto message = grid(60);
  spinFrames();
  const auto before = counts();
  for (int i = 0; i < 20; ++i) {
    auto* display = createMeshDisplay();
    for (int j = 0; j < 5; ++j) {
      geometry.publish(message);
    }
    if (i % 2) {
      spin(i);
    }
    delete display;
  }
  spinFrames();
  EXPECT_EQ(counts(), before);
}
