#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "base/hidden_faces.h"
#include "conversion/mesh_conversion.h"
#include "mesh_view/mesh_status.h"
#include "support/meshes.h"

using rviz_mesh_plugin::CostsState;
using rviz_mesh_plugin::GeometryState;
using rviz_mesh_plugin::geometryStatus;
using rviz_mesh_plugin::LabelsState;
using rviz_mesh_plugin::OptionalStatus;
using rviz_mesh_plugin::Reception;
using rviz_mesh_plugin::Section;
using rviz_mesh_plugin::sectionStatus;
using rviz_mesh_plugin::StatusLine;
using rviz_mesh_plugin::TexturesState;

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

/// Vertex Costs is chosen, the mesh has 4 vertices, and nothing has been
/// received.
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
  EXPECT_TRUE(says(rviz_mesh_plugin::topicStatus("/mesh", "", {3, 2, "", "it is empty"}),
                   StatusLine::OK,
                   "5 messages received; 2 of 5 messages refused, the last one: it is empty"));
  Reception served;
  served.accept("/get_geometry");
  EXPECT_TRUE(says(rviz_mesh_plugin::topicStatus("", "", served), StatusLine::OK,
                   "no topic chosen; the service /get_geometry has brought the mesh"));
  EXPECT_TRUE(
      says(rviz_mesh_plugin::topicStatus("/mesh", "", served), StatusLine::OK,
           "no message received on /mesh yet; the service /get_geometry has brought the mesh"));
  served.refuse("it is empty", "/get_geometry");
  EXPECT_EQ(served.received(), 0u);
  EXPECT_EQ(served.ignored(), "answer of the service /get_geometry ignored: it is empty");
  served.accept();
  EXPECT_EQ(served.ignored(), "");
  EXPECT_TRUE(says(rviz_mesh_plugin::topicStatus("/mesh", "", served), StatusLine::OK,
                   "1 message received; before, the service /get_geometry has brought"));
}

TEST(GeometryStatus, gives_the_numbers_or_the_reason)
{
  GeometryState state;
  EXPECT_FALSE(geometryStatus(state));
  state.working = "checking a mesh";
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::OK, "checking a mesh"));
  state.working.clear();
  state.mesh = rviz_mesh_plugin::convert(test_meshes::square());
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::OK,
                   "4 vertices, 2 faces, normals computed, uuid 'mesh'"));
  state.others = 2;
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::OK, "2 older meshes are shown too"));
  state.progress = 0.55f;
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::OK, "; 50 % uploaded"));
  state.preview = true;
  state.working = "laying out 2 faces";
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::OK,
                   "; a coarse picture is shown so far; laying out 2 faces"));
  state.drawn = false;
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::OK, "; not drawn yet; laying out 2 faces"));
  state.reception = {1, 1, "face 1 is bad", ""};
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::ERROR,
                   "message ignored: face 1 is bad; the mesh before it stays"));
  state.mesh.reset();
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::ERROR, "message ignored: face 1 is bad"));
  state.error = "out of memory";
  EXPECT_TRUE(
      says(geometryStatus(state), StatusLine::ERROR, "the mesh cannot be drawn: out of memory"));
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

TEST(GeometryStatus, warns_of_what_is_not_seen_as_it_is)
{
  GeometryState state;
  auto point = test_meshes::square();
  for (auto& vertex : point.mesh_geometry.vertices) {
    vertex = test_meshes::point(1, 2, 3);
  }
  state.mesh = rviz_mesh_plugin::convert(point);
  EXPECT_TRUE(
      says(geometryStatus(state), StatusLine::WARN,
           "all 4 vertices lie in one point, (1, 2, 3), so that nothing can be seen: look "));
  auto named = test_meshes::square();
  named.uuid = std::string(1000000, 'u');
  state.mesh = rviz_mesh_plugin::convert(named);
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::WARN, "the uuid has 1000000 characters"));
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::WARN, "4 vertices, 2 faces"));
  EXPECT_LT(geometryStatus(state)->text.size(), 500u);
  named.uuid = std::string(200, 'u');
  state.mesh = rviz_mesh_plugin::convert(named);
  EXPECT_TRUE(says(geometryStatus(state), StatusLine::OK, "4 vertices, 2 faces"));
}

TEST(LayerStatus, warns_where_all_that_came_belongs_to_another_geometry)
{
  CostsState costs = chosenCosts();
  costs.reception.accepted = 2;
  costs.uuid = "new";
  costs.waiting = 2;
  costs.waiting_uuid = "old";
  rviz_mesh_plugin::ColorsState colors = costs;
  rviz_mesh_plugin::LabelsState labels;
  static_cast<rviz_mesh_plugin::AttributeState&>(labels) = costs;
  const std::string ids = "; that is 'old', but 'new' is shown: choose topics of the same map";
  for (const bool chosen : {true, false}) {
    costs.chosen = colors.chosen = chosen;
    EXPECT_TRUE(says(costsStatus(costs), StatusLine::WARN,
                     "2 layers wait for a geometry with their uuid" + ids));
    EXPECT_TRUE(says(colorsStatus(colors), StatusLine::WARN,
                     "2 sets of colors wait for a geometry with their uuid" + ids));
  }
  EXPECT_TRUE(says(labelsStatus(labels), StatusLine::WARN,
                   "2 labels wait for a geometry with their uuid" + ids));
  labels.labels = 1;
  EXPECT_TRUE(says(labelsStatus(labels), StatusLine::OK, "1 label"));
  costs.types = {"a"};
  EXPECT_TRUE(says(costsStatus(costs), StatusLine::OK, "1 layer: 'a'"));
  costs.types.clear();
  costs.mesh_shown = false;
  EXPECT_TRUE(says(costsStatus(costs), StatusLine::OK, "2 layers wait"));
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
                   "layer 'Potential' has not arrived; there are 'a', 'b'"));
  state.left_out = 3;
  state.chosen_left_out = true;
  EXPECT_TRUE(says(costsStatus(state), StatusLine::WARN,
                   "layer 'Potential' has given way to newer ones; 3 layers are left out: those of "
                   "a mesh take more than 2 GiB; there are 'a', 'b'"));
  state.left_out = 0;
  state.chosen_left_out = false;
  state.type = "a";
  state.size = 3;
  EXPECT_TRUE(
      says(costsStatus(state), StatusLine::ERROR, "layer 'a': there are 3 costs for 4 vertices"));
  state.size = 4;
  state.summary = rviz_mesh_plugin::summarizeCosts({0.25f, 2.0f, NAN, INFINITY});
  state.limits = {0.0f, 1.0f};
  EXPECT_TRUE(says(costsStatus(state), StatusLine::OK,
                   "'a': 2 costs from 0.25 to 2, 1 lethal, 1 unknown; colors from 0 to 1"));
  state.left_out = 1;
  EXPECT_TRUE(says(costsStatus(state), StatusLine::WARN,
                   "colors from 0 to 1; 1 layer is left out: those of a mesh take more than 2 GiB; "
                   "have fewer published"));
  state.left_out = 0;
  state.limits = {1.0f, 0.5f};
  EXPECT_TRUE(says(costsStatus(state), StatusLine::WARN, "lower limit 1 is above the upper 0.5"));
}

TEST(CostsStatus, reports_refused_messages_whatever_is_chosen)
{
  CostsState state = chosenCosts();
  state.chosen = false;
  state.reception = {0, 1, "the cost of vertex 2 is -inf", ""};
  EXPECT_TRUE(
      says(costsStatus(state), StatusLine::ERROR, "message ignored: the cost of vertex 2 is -inf"));
  state.subscription_error = "bad name";
  EXPECT_TRUE(says(costsStatus(state), StatusLine::ERROR, "bad name"));
}

TEST(ColorsStatus, leads_to_the_colors)
{
  rviz_mesh_plugin::ColorsState state;
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

TEST(CostsStatus, counts_faces_for_layers_of_faces_and_tells_of_updates)
{
  CostsState state = chosenCosts();
  state.types = {"a"};
  state.type = "a";
  state.on_faces = true;
  state.face_count = 2;
  state.size = 4;
  EXPECT_TRUE(
      says(costsStatus(state), StatusLine::ERROR, "layer 'a': there are 4 costs for 2 faces"));
  state.size = 2;
  state.note = "the scale is linear";
  EXPECT_TRUE(says(costsStatus(state), StatusLine::OK, "(of faces); the scale is linear; colors"));
  state.stale_updates = 3;
  EXPECT_TRUE(says(costsStatus(state), StatusLine::OK,
                   "; 3 updates are left out, older by the stamp than what is shown; colors"));
  state.updates_reception = {4, 1, "", "it names vertex -1"};
  EXPECT_TRUE(says(costsStatus(state), StatusLine::OK,
                   "; 1 of 5 messages refused, the last one: it names vertex -1"));
  state.update_problem = "vertex 7 is too much";
  EXPECT_TRUE(says(costsStatus(state), StatusLine::ERROR, "update ignored: vertex 7 is too much"));
}

TEST(TexturesStatus, leads_from_nothing_to_the_textures)
{
  TexturesState state;
  EXPECT_FALSE(texturesStatus(state));
  state.chosen = true;
  state.mesh_shown = true;
  state.vertex_count = 4;
  state.face_count = 2;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::WARN, "set 'Materials Topic'"));
  auto materials = std::make_shared<rviz_mesh_plugin::Materials>();
  materials->materials.resize(3);
  materials->materials[0].texture_index = 7;
  materials->materials[1].texture_index = 7;
  materials->materials[2].texture_index = 8;
  materials->faces = {0, 1};
  materials->face_materials = {0, 2};
  state.materials = materials;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::WARN, "without texture coordinates"));
  materials->texture_coordinates.resize(4);
  state.textures = 1;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::WARN,
                   "3 materials on 2 faces, 1 of 2 textures received; until "
                   "the others come"));
  state.chosen = false;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::OK, "1 of 2 textures"));
  state.chosen = true;
  state.textures_left_out = 1;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::WARN,
                   "1 of 2 textures received; 1 texture is left out: those of a mesh take more "
                   "than 2 GiB; have smaller images published; its faces have the color of the "
                   "material"));
  materials->materials[0].texture_index = 9;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::WARN, "; until the others come"));
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::WARN, "1 texture is left out"));
  materials->materials[0].texture_index = 7;
  state.textures_left_out = 0;
  state.textures = 2;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::OK, "2 of 2 textures received"));
  state.vertex_count = 5;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::ERROR,
                   "there are 4 texture coordinates for 5 vertices"));
  state.face_count = 1;
  EXPECT_TRUE(says(texturesStatus(state), StatusLine::ERROR,
                   "the materials refer to face 1, but the mesh has 1 face"));
  state.textures_reception = {0, 1, "the image is empty", ""};
  EXPECT_TRUE(
      says(texturesStatus(state), StatusLine::ERROR, "message ignored: the image is empty"));
}

TEST(SectionStatus, tells_what_is_cut_away_and_how_far_the_mesh_reaches)
{
  const auto mesh = rviz_mesh_plugin::convert(test_meshes::square(1.5));
  Section section;
  EXPECT_FALSE(sectionStatus(false, section, mesh.get())) << "not asked for";
  EXPECT_TRUE(says(sectionStatus(true, section, mesh.get()), StatusLine::OK,
                   "nothing is cut away: no limit is set; the mesh reaches from height 1.5 to 1.5 "
                   "m, x -1 to 1 m, y -1 to 1 m"));
  section.upper[2] = 2.5f;
  EXPECT_TRUE(says(sectionStatus(true, section, mesh.get()), StatusLine::OK,
                   "the mesh is cut: what is drawn, pointed at and selected is height to 2.5 m; "
                   "the mesh reaches from height 1.5"));
  section.lower = {-0.5f, section.lower[1], 1.0f};
  section.upper[1] = 0.25f;
  EXPECT_TRUE(says(sectionStatus(true, section, nullptr), StatusLine::OK,
                   "is height from 1 to 2.5 m, x from -0.5 m, y to 0.25 m"));
  EXPECT_TRUE(says(sectionStatus(true, section, mesh.get(), true), StatusLine::WARN,
                   "nothing is drawn: no face of the mesh is at height from 1 to 2.5 m, x from"));
  section.lower[2] = 2.0f;
  EXPECT_TRUE(says(sectionStatus(true, section, mesh.get()), StatusLine::WARN,
                   "all of the mesh is cut away but height from 2 to 2.5 m"));
  section.lower[2] = 3.0f;
  EXPECT_TRUE(says(sectionStatus(true, section, mesh.get()), StatusLine::WARN,
                   "nothing is drawn: no height from 3 to 2.5 m: turn the limits round"));
}

TEST(LabelsStatus, counts_and_tells_what_was_left_out)
{
  LabelsState state;
  EXPECT_FALSE(labelsStatus(state));
  state.chosen = true;
  state.mesh_shown = true;
  EXPECT_TRUE(says(labelsStatus(state), StatusLine::OK, "no label of this mesh received yet"));
  state.labels = 1;
  EXPECT_TRUE(says(labelsStatus(state), StatusLine::OK, "1 label"));
  state.left_out = 3;
  EXPECT_TRUE(says(labelsStatus(state), StatusLine::WARN,
                   "3 faces that the mesh does not have are left out"));
  state.error = "out of memory";
  EXPECT_TRUE(says(labelsStatus(state), StatusLine::ERROR, "cannot be drawn: out of memory"));
}

TEST(MeshStatus, says_how_many_faces_are_hidden)
{
  auto message = test_meshes::square();
  message.uuid = "partly hidden";
  const auto mesh = rviz_mesh_plugin::convert(message);
  EXPECT_FALSE(rviz_mesh_plugin::hiddenStatus({}));
  EXPECT_FALSE(rviz_mesh_plugin::hiddenStatus({mesh}));
  const auto hide = [&](const rviz_mesh_plugin::FaceBits::Faces& faces) {
    rviz_mesh_plugin::setHiddenFaces(*mesh, std::make_shared<const rviz_mesh_plugin::HiddenFaces>(
                                                rviz_mesh_plugin::FaceBits(2, faces)));
  };
  hide({1});
  EXPECT_TRUE(says(rviz_mesh_plugin::hiddenStatus({mesh}), StatusLine::OK,
                   "1 of 2 faces are hidden: 'Show All'"));
  EXPECT_TRUE(says(rviz_mesh_plugin::hiddenStatus({mesh}, true), StatusLine::WARN,
                   "nothing is drawn: 1 of 2 faces are hidden, all of the section: 'Show All'"));
  hide({0, 1});
  EXPECT_TRUE(says(rviz_mesh_plugin::hiddenStatus({mesh}), StatusLine::WARN,
                   "nothing is drawn: all 2 faces are hidden"));
  hide({});
  EXPECT_FALSE(rviz_mesh_plugin::hiddenStatus({mesh}));
}
