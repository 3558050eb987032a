#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <rviz/config.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>

#include "displays/label_names.h"
#include "support/label_display_fixture.h"
#include "support/label_fixture.h"
#include "support/service_servers.h"
#include "threads/cancellation.h"

using osmesa_harness::Rgb;
using rviz_mesh_plugin::MeshSource;
using rviz_mesh_plugin::Rgba8;
using test_labels::colorOf;
using test_labels::ROW;
using test_labels::rows;

namespace {

/// size * size cells of 1 m and two faces each, row by row.
rviz_mesh_plugin::MeshData flatMesh(std::uint32_t size)
{
  rviz_mesh_plugin::MeshData mesh;
  for (std::uint32_t i = 0; i < (size + 1) * (size + 1); ++i) {
    mesh.vertices.push_back(
        {{static_cast<float>(i % (size + 1)), static_cast<float>(i / (size + 1)), 0.0f}, {}});
  }
  for (std::uint32_t i = 0; i < size * size; ++i) {
    const std::uint32_t corner = i / size * (size + 1) + i % size, above = corner + size + 1;
    for (const std::uint32_t vertex : {corner, corner + 1, above, above, corner + 1, above + 1}) {
      mesh.indices.push_back(vertex);
    }
  }
  return mesh;
}

}  // namespace

class ClusterLabelTest : public LabelDisplayFixture
{
};

TEST_F(ClusterLabelTest, shows_all_labels_of_the_service_in_the_colors_of_their_classes)
{
  server->addLabel("tree_1", rows(10, 0, 2));
  server->addLabel("tree_2", rows(10, 3, 4));
  server->addLabel("wall_1", rows(10, 5, 8));
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "Ok: 3 labels of 2 classes on 120 faces"));
  EXPECT_TRUE(says(display, "Geometry", "Ok: 200 faces"));
  EXPECT_TRUE(says(display, "Transform", "Ok: frame 'map'"));
  EXPECT_TRUE(says(display, "Services", "Ok:"));
  const auto image = picture();
  EXPECT_EQ(image.count(colorOf("tree")), 3 * ROW);
  EXPECT_EQ(image.count(colorOf("wall")), 3 * ROW);
  EXPECT_EQ(display->labels().at("tree_2")->faces, rows(10, 3, 4));
  EXPECT_EQ(display->mesh()->faceCount(), 200u);
}

TEST_F(ClusterLabelTest, shows_what_changes_and_takes_away_what_is_deleted)
{
  server->addLabel("tree_1", rows(10, 0, 2));
  auto* display = createLabels("rviz_map_plugin/ClusterLabel");
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "1 label of 1 class"));
  server->labels.publish(LabelServer::cluster("tree_2", rows(10, 2, 3)));
  ASSERT_TRUE(says(display, "Labels", "2 labels of 1 class on 60 faces"));
  EXPECT_EQ(picture().count(colorOf("tree")), 3 * ROW);
  server->labels.publish(LabelServer::cluster("tree_1", rows(10, 0, 1)));
  ASSERT_TRUE(says(display, "Labels", "on 40 faces"));
  EXPECT_EQ(picture().count(colorOf("tree")), 2 * ROW);
  server->labels.publish(LabelServer::cluster("tree_1", {}));
  ASSERT_TRUE(says(display, "Labels", "1 label of 1 class on 20 faces"));
  EXPECT_EQ(picture().count(colorOf("tree")), ROW);
  EXPECT_EQ(find(display, {"Colors"})->numChildren(), 1);
  server->labels.publish(LabelServer::cluster("tree_3", {5, 200, 300}));
  EXPECT_TRUE(says(display, "Labels", "Warn: 2 labels of 1 class on 21 faces; 2 indices left out"));
}

TEST_F(ClusterLabelTest, labels_that_arrive_before_their_mesh_wait_for_it)
{
  auto* display = createLabels();
  ASSERT_TRUE(spinUntil([&] { return server->labels.getNumSubscribers() > 0; }));
  server->labels.publish(LabelServer::cluster("tree_1", rows(10, 0, 1)));
  EXPECT_TRUE(says(display, "Geometry", "Warn: no mesh received"));
  spin(200);
  server->addLabel("tree_1", rows(10, 0, 1));
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "1 label of 1 class on 20 faces"));
}

TEST_F(ClusterLabelTest, one_question_for_all_labels_waits_for_the_answer_to_the_other)
{
  server->addLabel("tree_1", rows(10, 0, 1));
  server->answer(0);
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(spinUntil([&] { return server->asked() == 1; }));
  display->askForLabels();
  display->askForLabels();
  spinFrames(5);
  server->answer(1);
  EXPECT_TRUE(says(display, "Labels", "1 label of")) << "its answer is not lost";
  ASSERT_TRUE(spinUntil([&] { return server->asked() == 2; }));
  server->labels.publish(LabelServer::cluster("tree_1", rows(10, 0, 2)));
  ASSERT_TRUE(says(display, "Labels", "1 label of 1 class on 40 faces"));
  server->addLabel("tree_2", rows(10, 2, 3));
  server->answer(3);
  ASSERT_TRUE(says(display, "Labels", "2 labels of"));
  EXPECT_EQ(display->labels().at("tree_1")->faces, rows(10, 0, 2)) << "which came meanwhile";
  spinFrames(5);
  EXPECT_EQ(server->asked(), 2) << "both are one question";
}

/// The display does not take a message while it is not updated.
TEST_F(ClusterLabelTest, what_came_before_a_question_for_all_labels_is_older_than_its_answer)
{
  server->addLabel("tree_1", rows(10, 0, 1));
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "1 label of"));
  ASSERT_TRUE(spinUntil([&] { return server->labels.getNumSubscribers() > 0; }));
  bool is_older = false;
  // On a busy machine the message may come after the question.
  for (std::uint32_t i = 0; i < 20 && !is_older; ++i) {
    server->labels.publish(LabelServer::cluster("tree_1", {i}));
    std::this_thread::sleep_for(std::chrono::milliseconds(20 * (i + 1)));
    const std::string newest = "newest_" + std::to_string(i);
    server->addLabel("tree_1", {100 + i});
    server->addLabel(newest, {199});
    display->askForLabels();
    ASSERT_TRUE(spinUntil([&] { return display->labels().count(newest) != 0; }));
    is_older = display->labels().at("tree_1")->faces.front() == 100 + i;
  }
  EXPECT_TRUE(is_older) << "the answer was left out for what it is newer than";
}

/// The display takes both at once.
TEST_F(ClusterLabelTest, an_answer_that_comes_with_another_mesh_of_the_name_is_not_about_that)
{
  server->addLabel("tree_1", rows(10, 0, 1));
  server->answer(0);
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(spinUntil([&] { return server->asked() == 1; }));
  geometry.publish(test_meshes::terrain(11, [](double, double) { return 0.0; }));
  server->answer(1);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  ASSERT_TRUE(spinUntil([&] { return server->asked() == 2; }));
  spinFrames(5);
  EXPECT_FALSE(display->labelsComplete());
  EXPECT_TRUE(display->labels().empty());
  server->answer(2);
  EXPECT_TRUE(spinUntil([&] { return display->labelsComplete(); }));
  EXPECT_EQ(display->labels().count("tree_1"), 1u);
}

TEST_F(ClusterLabelTest, enabled_again_what_comes_before_all_labels_is_newer_than_they)
{
  server->addLabel("tree_1", rows(10, 0, 1));
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "1 label of 1 class on 20 faces"));
  display->setEnabled(false);
  server->answer(1);
  server->addLabel("tree_2", rows(10, 2, 3));
  display->setEnabled(true);
  ASSERT_TRUE(
      spinUntil([&] { return server->asked() == 2 && server->labels.getNumSubscribers() > 0; }));
  server->labels.publish(LabelServer::cluster("tree_1", rows(10, 0, 2)));
  ASSERT_TRUE(says(display, "Labels", "1 label of 1 class on 40 faces"));
  server->answer(2);
  EXPECT_TRUE(spinUntil([&] { return display->labels().count("tree_2") != 0; }));
  EXPECT_EQ(display->labels().at("tree_1")->faces, rows(10, 0, 2));
}

TEST_F(ClusterLabelTest, a_class_and_a_label_can_be_hidden_and_the_whole_faded)
{
  server->addLabel("tree_1", rows(10, 0, 2));
  server->addLabel("tree_2", rows(10, 3, 4));
  server->addLabel("wall_1", rows(10, 5, 8));
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "3 labels"));
  set(display, {"Visible Labels", "tree", "tree_1"}, false);
  EXPECT_TRUE(says(display, "Labels", "1 hidden"));
  EXPECT_EQ(picture().count(colorOf("tree")), ROW);
  set(display, {"Visible Labels", "tree"}, false);
  EXPECT_TRUE(says(display, "Labels", "2 hidden"));
  EXPECT_EQ(picture().count(colorOf("tree")), 0u);
  set(display, {"Visible Labels", "tree"}, true);
  EXPECT_EQ(picture().count(colorOf("tree")), ROW) << "tree_1 is still hidden";
  set(display, {"Transparency"}, 0.5f);
  EXPECT_EQ(picture().count(colorOf("wall")), 0u);
  set(display, {"Transparency"}, 1.0f);
  EXPECT_EQ(picture().count(colorOf("wall")), 3 * ROW);
  set(display, {"Show Phantom"}, true);
  spinFrames();
  EXPECT_EQ(picture().count({48, 48, 48}), 640u * 480u - 10 * ROW);
}

TEST_F(ClusterLabelTest, names_stand_over_the_labels_that_are_shown)
{
  using Names = std::vector<std::string>;
  server->addLabel("tree_1", rows(10, 0, 2));
  server->addLabel("wall_1", rows(10, 5, 9));
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "2 labels"));
  const auto without = picture();
  EXPECT_EQ(display->drawnNames(), Names());
  set(display, {"Show Names"}, true);
  ASSERT_TRUE(spinUntil([&] { return display->drawnNames().size() == 2; }));
  EXPECT_EQ(display->drawnNames(), Names({"wall_1", "tree_1"})) << "the largest first";
  const auto with = picture();
  EXPECT_LT(with.count(colorOf("tree")), without.count(colorOf("tree"))) << "the name lies on it";
  EXPECT_LT(with.count(colorOf("wall")), without.count(colorOf("wall")));
  EXPECT_GT(with.count({255, 255, 255}), without.count({255, 255, 255}) + 20) << "letters";
  set(display, {"Visible Labels", "tree", "tree_1"}, false);
  ASSERT_TRUE(spinUntil([&] { return display->drawnNames() == Names{"wall_1"}; }));
  server->labels.publish(LabelServer::cluster("wall_1", {}));
  ASSERT_TRUE(spinUntil([&] { return display->drawnNames().empty(); }));
  server->labels.publish(LabelServer::cluster("wall_2", rows(10, 5, 8)));
  ASSERT_TRUE(spinUntil([&] { return display->drawnNames() == Names{"wall_2"}; }));
  set(display, {"Show Names"}, false);
  spinFrames();
  EXPECT_EQ(display->drawnNames(), Names());
  EXPECT_EQ(picture().count({255, 255, 255}), without.count({255, 255, 255}));
}

TEST_F(ClusterLabelTest, of_many_labels_the_largest_have_names_and_none_covers_another)
{
  for (std::uint32_t i = 0; i < 60; ++i) {
    std::vector<std::uint32_t> faces{3 * i, 3 * i + 1};
    faces.resize(i < 50 ? 2 : 1);
    server->addLabel("tree_" + std::to_string(i), faces);
  }
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "60 labels"));
  set(display, {"Show Names"}, true);
  ASSERT_TRUE(spinUntil([&] { return display->drawnNames().size() > 5; }));
  EXPECT_TRUE(says(display, "Labels", "10 without their name in the picture"));
  for (const std::string& name : display->drawnNames()) {
    EXPECT_LT(std::stoi(name.substr(5)), 50) << name;
  }
  EXPECT_LT(display->drawnNames().size(), 50u) << "there is no room for all of them";
}

TEST(LabelNamesTest, a_name_stands_on_its_label)
{
  const auto mesh = flatMesh(10);
  rviz_mesh_plugin::LabelCluster label;
  for (std::uint32_t i = 0; i < 10; ++i) {  // the sides of a square, whose middle is far from them
    for (const std::uint32_t cell : {i, 90 + i, 10 * i, 10 * i + 9}) {
      label.faces.push_back(2 * cell);
    }
  }
  std::sort(label.faces.begin(), label.faces.end());
  const auto place = rviz_mesh_plugin::placeOfName(mesh, label.faces);
  const std::uint32_t cell =
      static_cast<std::uint32_t>(place[1]) * 10 + static_cast<std::uint32_t>(place[0]);
  EXPECT_EQ(std::count(label.faces.begin(), label.faces.end(), 2 * cell), 1);
  const std::atomic<bool> canceled{true};
  EXPECT_THROW(rviz_mesh_plugin::placeOfName(mesh, label.faces, &canceled),
               rviz_mesh_plugin::Canceled);
}

TEST_F(ClusterLabelTest, what_is_saved_is_loaded_before_there_are_labels)
{
  server->addLabel("tree_1", rows(10, 0, 2));
  server->addLabel("wall_1", rows(10, 5, 8));
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "2 labels"));
  set(display, {"Active label"}, "tree_1");
  set(display, {"Brush Size"}, 0.25f);
  set(display, {"Visible Labels", "tree", "tree_1"}, false);
  set(display, {"Visible Labels", "wall"}, false);
  rviz::Config saved;
  display->save(saved);
  EXPECT_FALSE(saved.mapGetChild("Colors").isValid()) << "colors are with the map";
  delete display;
  spinFrames();
  auto* other = createDisplayAs<Display>("rviz_mesh_plugin/ClusterLabel");
  other->load(saved);
  EXPECT_EQ(find(other, {"Active label"})->getValue().toString(), "tree_1")
      << "before there are labels";
  EXPECT_EQ(other->brushSize(), 0.25f);
  ASSERT_TRUE(says(other, "Labels", "2 labels of 2 classes on 100 faces, 2 hidden"));
  EXPECT_EQ(find(other, {"Active label"})->getValue().toString(), "tree_1");
  EXPECT_EQ(picture().count({48, 48, 48}), 640u * 480u);
  rviz::Config again;
  other->save(again);
  for (const char* list : {"Hidden Classes", "Hidden Labels"}) {
    const auto names = again.mapGetChild("Visible Labels").mapGetChild(list);
    ASSERT_EQ(names.listLength(), 1) << list;
  }
  set(other, {"Active label"}, "__NEW__");
  EXPECT_EQ(find(other, {"Active label"})->getValue().toString(), "__NEW__");
}

TEST_F(ClusterLabelTest, released_properties_have_their_names_types_and_defaults)
{
  auto* display = createDisplayAs<Display>("rviz_map_plugin/ClusterLabel");
  EXPECT_EQ(find(display, {"Active label"})->getValue(), QVariant("__NEW__"));
  EXPECT_TRUE(dynamic_cast<rviz::EnumProperty*>(find(display, {"Active label"})));
  EXPECT_EQ(find(display, {"Transparency"})->getValue().toFloat(), 1.0f);
  EXPECT_EQ(find(display, {"Brush Size"})->getValue().toFloat(), 1.0f);
  EXPECT_EQ(find(display, {"Show Phantom"})->getValue(), QVariant(false));
  EXPECT_EQ(find(display, {"Colors"})->numChildren(), 0);
  EXPECT_TRUE(says(display, "Geometry", "Error: there is no mesh to label: choose"));
  MeshSource source;
  display->setSource(source);
  EXPECT_TRUE(says(display, "Geometry", "Warn: no map is open"));
  source.geometry_topic = geometry_topic;
  source.labels_topic = name_space + "/new_cluster_label";
  source.service_namespace = name_space;
  source.frame = "nowhere";
  server->addLabel("tree_1", rows(10, 0, 2));
  display->setSource(source);
  EXPECT_TRUE(find(display, {"Geometry Topic"})->getHidden());
  EXPECT_TRUE(find(display, {"Labels Topic"})->getHidden());
  publishMesh();
  ASSERT_TRUE(says(display, "Transform", "Error: no transform from frame 'nowhere'"));
  ASSERT_TRUE(says(display, "Labels", "1 label of 1 class"));
  EXPECT_EQ(picture().count({48, 48, 48}), 640u * 480u);
}

TEST_F(ClusterLabelTest, add_by_topic_finds_the_mesh_beside_the_labels)
{
  auto* display = createDisplayAs<Display>("rviz_mesh_plugin/ClusterLabel");
  display->setTopic("/map/new_cluster_label", "mesh_msgs/MeshFaceCluster");
  EXPECT_EQ(find(display, {"Labels Topic"})->getValue(), QVariant("/map/new_cluster_label"));
  EXPECT_EQ(find(display, {"Geometry Topic"})->getValue(), QVariant("/map/mesh/geometry"));
}

TEST_F(ClusterLabelTest, edits_go_to_the_owner_and_show_once_they_are_stored)
{
  auto* display = createLabels();
  EXPECT_NE(display->storeFaces("tree_1", rviz_mesh_plugin::labelFaces({1}), true).find("no mesh"),
            std::string::npos);
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "the mesh has no labels (yet)"));
  EXPECT_NE(display->storeFaces("tree_1", rviz_mesh_plugin::labelFaces({1}), true)
                .find("nobody stores labels"),
            std::string::npos);
  EXPECT_NE(display->storeFaces("", rviz_mesh_plugin::labelFaces({1}), true).find("no name"),
            std::string::npos);
  server->listen(name_space);
  ASSERT_TRUE(spinUntil([&] {
    return display->storeFaces("tree_1", rviz_mesh_plugin::labelFaces(rows(10, 0, 1)), true)
        .empty();
  }));
  ASSERT_TRUE(spinUntil([&] { return !server->edits().empty(); }));
  const auto edit = server->edits().back();
  EXPECT_EQ(edit.uuid, "mesh");
  EXPECT_EQ(edit.header.frame_id, "map");
  EXPECT_EQ(edit.cluster.label, "tree_1");
  EXPECT_EQ(edit.cluster.face_indices, rows(10, 0, 1));
  EXPECT_TRUE(edit.override);
  EXPECT_TRUE(display->labels().empty());
  server->labels.publish(edit.cluster);
  ASSERT_TRUE(says(display, "Labels", "1 label"));
}

TEST_F(ClusterLabelTest, a_label_has_its_own_color_where_its_owner_says_so)
{
  server->listen(name_space);
  server->addLabel("tree_1", rows(10, 0, 2));
  server->addLabel("tree_2", rows(10, 3, 4));
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "2 labels"));
  server->colors.publish(colorsOf({{"tree_2", {10, 20, 30}}}));
  ASSERT_TRUE(spinUntil([&] { return picture().count({10, 20, 30}) == ROW; }));
  EXPECT_EQ(picture().count(colorOf("tree")), 2 * ROW);
  EXPECT_EQ(find(display, {"Colors", "tree_2"})->getValue(), QVariant("10; 20; 30"));
  // The user's choice goes to the owner, and shows when that says so.
  set(display, {"Colors", "tree_1"}, QColor(255, 0, 51));
  ASSERT_TRUE(spinUntil([&] { return server->colorsSet().size() == 1; }));
  const auto request = server->colorsSet()[0];
  EXPECT_EQ(request.uuid, "mesh");
  EXPECT_EQ(request.label, "tree_1");
  EXPECT_FLOAT_EQ(request.color.r, 1.0f);
  EXPECT_FLOAT_EQ(request.color.g, 0.0f);
  EXPECT_FLOAT_EQ(request.color.b, 0.2f);
  EXPECT_EQ(request.color.a, 1.0f);
  EXPECT_EQ(picture().count(colorOf("tree")), 2 * ROW) << "not stored yet";
  server->colors.publish(colorsOf({{"tree_1", {255, 0, 51}}}));
  ASSERT_TRUE(spinUntil([&] { return picture().count({255, 0, 51}) == 2 * ROW; }));
  EXPECT_EQ(picture().count(colorOf("tree")), ROW) << "tree_2 has none any more";
  // The color of the class takes the label's own away.
  const Rgb of_class = colorOf("tree");
  set(display, {"Colors", "tree_1"}, QColor(of_class.red, of_class.green, of_class.blue));
  ASSERT_TRUE(spinUntil([&] { return server->colorsSet().size() == 2; }));
  EXPECT_EQ(server->colorsSet()[1].color.a, 0.0f);
  server->refusal = "the map is\nread-only";
  set(display, {"Colors", "tree_2"}, QColor(1, 2, 3));
  EXPECT_TRUE(says(display, "Edits",
                   "Error: the color of 'tree_2' is not stored: " + name_space +
                       "/set_label_color refuses it: the map is read-only"));
}

TEST_F(ClusterLabelTest, a_color_that_is_never_answered_holds_up_nothing)
{
  service_servers::Gate gate;
  server->before_colors = [&] { gate.pass(); };
  server->listen(name_space);
  server->addLabel("tree_1", rows(10, 0, 2));
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "1 label"));
  const auto threads = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"),
                         std::filesystem::directory_iterator());
  };
  display->setEnabled(false);
  spinFrames(5);
  const auto idle = threads();
  display->setEnabled(true);
  const Rgba8 red{255, 0, 0, 255};
  ASSERT_TRUE(spinUntil([&] { return display->setLabelColor("tree_1", &red).empty(); }));
  ASSERT_TRUE(spinUntil([&] { return gate.reached == 1; }));
  display->setEnabled(false);
  EXPECT_TRUE(spinUntil([&] { return threads() <= idle; })) << "the asking thread is over";
  delete display;
  gate.open();
}

TEST_F(ClusterLabelTest, nothing_is_left_after_disabling_reset_and_removal)
{
  server->addLabel("tree_1", rows(10, 0, 2));
  server->addLabel("wall_1", rows(10, 5, 8));
  delete createLabels();
  spinFrames();
  const auto empty = counts();
  auto* display = createLabels();
  publishMesh();
  ASSERT_TRUE(says(display, "Labels", "2 labels"));
  picture();
  const auto shown = counts();
  for (int i = 0; i < 50; ++i) {
    display->setEnabled(false);
    display->setEnabled(true);
    if (i % 10 == 0) {
      display->reset();
    }
  }
  ASSERT_TRUE(says(display, "Labels", "2 labels"));
  ASSERT_TRUE(spinUntil([&] {
    picture();
    return counts() == shown;
  })) << counts();
  EXPECT_EQ(picture().count(colorOf("tree")), 2 * ROW);
  display->setEnabled(false);
  EXPECT_EQ(picture().count({48, 48, 48}), 640u * 480u);
  display->setEnabled(true);
  ASSERT_TRUE(says(display, "Transform", "Ok"));
  EXPECT_EQ(picture().count(colorOf("tree")), 2 * ROW) << "at once";
  delete display;
  EXPECT_EQ(counts(), empty);
}

TEST_F(ClusterLabelTest, ten_thousand_labels_do_not_block)
{
  for (std::uint32_t i = 0; i < 10000; ++i) {
    server->addLabel("cell" + std::to_string(i % 50) + "_" + std::to_string(i), {i % 200});
  }
  auto* display = createLabels();
  publishMesh();
  std::chrono::steady_clock::duration longest{};
  const auto shown = [&] {
    const auto start = std::chrono::steady_clock::now();
    display->update(0.0f, 0.0f);
    longest = std::max(longest, std::chrono::steady_clock::now() - start);
    return find(display, {"Colors"})->numChildren() == 10000 &&
           status(display, "Labels").find("to be shown") == std::string::npos;
  };
  ASSERT_TRUE(spinUntil(shown, 60000)) << status(display, "Labels");
  EXPECT_TRUE(says(display, "Labels", "10000 labels of 50 classes"));
  RecordProperty(
      "longest_update_ms",
      static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(longest).count()));
  EXPECT_EQ(picture().count({48, 48, 48}), 640u * 480u - 10 * ROW);
}
