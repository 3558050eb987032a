#include <string>

#include <gtest/gtest.h>

#include "meshes.h"
#include "rviz_mesh_plugin/mesh_conversion.h"
#include "rviz_mesh_plugin/mesh_status.h"

using rviz_mesh_plugin::CostsState;
using rviz_mesh_plugin::geometryStatus;
using rviz_mesh_plugin::OptionalStatus;
using rviz_mesh_plugin::Reception;
using rviz_mesh_plugin::StatusLine;

namespace {

testing::AssertionResult says(const OptionalStatus& status, StatusLine::Level level,
                              const std::string& part)
{
  if (!status) {
    return testing::AssertionFailure() << "there is no status";
  }
  if (status->level != level || status->text.find(part) == std::string::npos) {
    return testing::AssertionFailure() << "level " << status->level << ": " << status->text;
  }
  return testing::AssertionSuccess();
}

/// Vertex Costs is chosen, the mesh has 4 vertices, and nothing has been received.
CostsState chosenCosts()
{
  CostsState state;
  state.chosen = true;
  state.topic = "/costs";
  state.mesh_shown = true;
  state.vertex_count = 4;
  return state;
}

}  // namespace

TEST(TopicStatus, tells_what_is_missing)
{
  EXPECT_TRUE(
      says(rviz_mesh_plugin::topicStatus("", "", {}), StatusLine::WARN, "set 'Geometry Topic'"));
  EXPECT_TRUE(says(rviz_mesh_plugin::topicStatus("/mesh", "", {}), StatusLine::WARN,
                   "no message received on /mesh"));
  EXPECT_TRUE(
      says(rviz_mesh_plugin::topicStatus("/m m", "bad name", {}), StatusLine::ERROR, "bad name"));
  EXPECT_TRUE(says(rviz_mesh_plugin::topicStatus("/mesh", "", {3, 2, ""}), StatusLine::OK,
                   "5 messages received; 2 of 5 messages refused"));
}

TEST(GeometryStatus, gives_the_numbers_or_the_reason)
{
  const auto mesh = rviz_mesh_plugin::convert(test_meshes::square());
  EXPECT_FALSE(geometryStatus(nullptr, Reception(), true));
  EXPECT_TRUE(says(geometryStatus(mesh, {1, 0, ""}, true), StatusLine::OK,
                   "4 vertices, 2 faces, normals computed, uuid 'mesh'"));
  EXPECT_TRUE(says(geometryStatus(nullptr, {0, 1, "face 1 is bad"}, true), StatusLine::ERROR,
                   "message ignored: face 1 is bad"));
  EXPECT_TRUE(says(geometryStatus(mesh, {1, 1, "face 1 is bad"}, true), StatusLine::ERROR,
                   "the mesh before it stays"));
}

TEST(CostsStatus, is_silent_while_nobody_asks_and_nothing_came)
{
  CostsState state = chosenCosts();
  state.chosen = false;
  EXPECT_FALSE(costsStatus(state));
  state.types = {"a", "b"};
  state.waiting = 1;
  EXPECT_TRUE(says(costsStatus(state), StatusLine::OK, "2 layers: 'a', 'b'; 1 layer waits"));
}

TEST(CostsStatus, leads_from_nothing_to_the_layer_step_by_step)
{
  CostsState state = chosenCosts();
  state.topic.clear();
  EXPECT_TRUE(says(costsStatus(state), StatusLine::WARN, "set 'Vertex Costs Topic'"));
  state.topic = "/costs";
  EXPECT_TRUE(says(costsStatus(state), StatusLine::WARN, "no costs received on /costs yet"));
  state.reception.accepted = 1;
  state.waiting = 1;
  EXPECT_TRUE(
      says(costsStatus(state), StatusLine::WARN, "1 layer waits for a geometry with its uuid"));
  state.waiting = 0;
  state.types = {"a", "b"};
  EXPECT_TRUE(
      says(costsStatus(state), StatusLine::WARN, "set 'Vertex Costs Type' to one of 'a', 'b'"));
  state.type = "Potential";
  EXPECT_TRUE(says(costsStatus(state), StatusLine::WARN,
                   "layer 'Potential' has not arrived, but 'a', 'b'"));
  state.type = "a";
  state.size = 3;
  EXPECT_TRUE(
      says(costsStatus(state), StatusLine::ERROR, "layer 'a': there are 3 costs for 4 vertices"));
  state.size = 4;
  state.summary = rviz_mesh_plugin::summarizeCosts({0.25f, 2.0f, NAN, INFINITY});
  state.limits = {0.0f, 1.0f};
  EXPECT_TRUE(says(costsStatus(state), StatusLine::OK,
                   "'a': 2 costs from 0.25 to 2, 1 lethal, 1 unknown; colors from 0 to 1"));
  state.limits = {1.0f, 0.5f};
  EXPECT_TRUE(says(costsStatus(state), StatusLine::WARN, "lower limit 1 is above the upper 0.5"));
}

TEST(CostsStatus, reports_refused_messages_whatever_is_chosen)
{
  CostsState state = chosenCosts();
  state.chosen = false;
  state.reception = {0, 1, "the cost of vertex 2 is -inf"};
  EXPECT_TRUE(
      says(costsStatus(state), StatusLine::ERROR, "message ignored: the cost of vertex 2 is -inf"));
  state.subscription_error = "bad name";
  EXPECT_TRUE(says(costsStatus(state), StatusLine::ERROR, "bad name"));
}

TEST(ColorsStatus, leads_to_the_colors)
{
  rviz_mesh_plugin::AttributeState state;
  EXPECT_FALSE(colorsStatus(state));
  state.chosen = true;
  state.mesh_shown = true;
  state.vertex_count = 4;
  EXPECT_TRUE(says(colorsStatus(state), StatusLine::WARN, "set 'Vertex Colors Topic'"));
  state.topic = "/colors";
  EXPECT_TRUE(says(colorsStatus(state), StatusLine::WARN, "no colors received on /colors yet"));
  state.reception.accepted = 1;
  state.waiting = 1;
  EXPECT_TRUE(says(colorsStatus(state), StatusLine::WARN, "waits for a geometry with its uuid"));
  state.size = 5;
  EXPECT_TRUE(says(colorsStatus(state), StatusLine::ERROR, "there are 5 colors for 4 vertices"));
  state.size = 4;
  EXPECT_TRUE(says(colorsStatus(state), StatusLine::OK, "4 colors"));
}
