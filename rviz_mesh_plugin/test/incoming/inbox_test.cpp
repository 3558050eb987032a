#include <array>
#include <atomic>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "incoming/attribute_queue.h"
#include "support/meshes.h"

using rviz_mesh_plugin::AttributeQueue;
using rviz_mesh_plugin::MeshMember;

namespace {

mesh_msgs::MeshFaceCostsStamped faceCosts(const std::string& type, float value)
{
  mesh_msgs::MeshFaceCostsStamped message;
  message.header.frame_id = "map";
  message.uuid = "mesh";
  message.type = type;
  message.mesh_face_costs.costs = {value};
  return message;
}

mesh_msgs::MeshVertexCostsSparseStamped update(const std::string& type, std::uint32_t vertex,
                                               float cost)
{
  mesh_msgs::MeshVertexCostsSparseStamped message;
  message.header.frame_id = "map";
  message.uuid = "mesh";
  message.type = type;
  message.mesh_vertex_costs.vertices = {vertex};
  message.mesh_vertex_costs.costs = {cost};
  return message;
}

mesh_msgs::MeshFaceCluster cluster(const std::string& label, std::vector<std::uint32_t> faces)
{
  mesh_msgs::MeshFaceCluster message;
  message.label = label;
  message.face_indices = std::move(faces);
  return message;
}

mesh_msgs::MeshTexture texture(std::uint32_t index)
{
  mesh_msgs::MeshTexture message;
  message.uuid = "mesh";
  message.texture_index = index;
  message.image.width = message.image.height = message.image.step = 1;
  message.image.encoding = "mono8";
  message.image.data = {7};
  return message;
}

}  // namespace

TEST(Inbox, keeps_vertex_and_face_layers_of_one_name_apart)
{
  AttributeQueue queue;
  EXPECT_TRUE(queue.receive(test_meshes::costs("slope", {1.0f, 2.0f})));
  EXPECT_TRUE(queue.receive(faceCosts("slope", 3.0f)));
  EXPECT_TRUE(queue.receive(faceCosts("slope", 4.0f)));
  auto content = queue.take();
  ASSERT_EQ(content.costs.size(), 2u);
  EXPECT_FALSE(content.costs[0]->on_faces);
  EXPECT_TRUE(content.costs[1]->on_faces);
  EXPECT_EQ(content.costs[1]->costs, std::vector<float>{4.0f});
  EXPECT_EQ(content.receptions[MeshMember::COSTS].accepted, 1u);
  EXPECT_EQ(content.receptions[MeshMember::FACE_COSTS].accepted, 2u);
  queue.receive(test_meshes::costs("slope", {1.0f}));
  queue.receive(faceCosts("slope", 3.0f));
  queue.forget(MeshMember::COSTS);
  content = queue.take();
  ASSERT_EQ(content.costs.size(), 1u);
  EXPECT_TRUE(content.costs[0]->on_faces) << "clearing vertex costs leaves those of faces";
  EXPECT_EQ(content.receptions[MeshMember::COSTS].accepted, 0u);
  EXPECT_EQ(content.receptions[MeshMember::FACE_COSTS].accepted, 3u);
}

TEST(Inbox, drops_updates_that_an_entire_layer_made_obsolete)
{
  AttributeQueue queue;
  queue.receive(test_meshes::costs("slope", {1.0f, 1.0f}));
  queue.receive(test_meshes::costs("other", {1.0f, 1.0f}));
  queue.receive(update("slope", 0, 1.0f));
  queue.receive(update("other", 1, 2.0f));
  queue.receive(test_meshes::costs("slope", {5.0f, 6.0f}));
  queue.receive(update("slope", 1, 3.0f));
  const auto content = queue.take();
  ASSERT_EQ(content.changed_costs.size(), 2u);
  EXPECT_EQ(content.changed_costs[0].layer->type, "other");
  EXPECT_EQ(content.changed_costs[1].layer->costs, (std::vector<float>{5.0f, 3.0f}));
  EXPECT_EQ(content.receptions[MeshMember::UPDATES].accepted, 3u);
  EXPECT_TRUE(queue.take().changed_costs.empty());
}

TEST(Inbox, updates_are_merged_where_they_are_received)
{
  AttributeQueue queue;
  queue.receive(test_meshes::costs("slope", std::vector<float>(31)));
  const auto layer = queue.take().costs.at(0);
  std::vector<float> expected(31);
  for (int i = 0; i < 1000; ++i) {
    const std::uint32_t vertex = (i * 7) % 31;
    queue.receive(update("slope", vertex, static_cast<float>(i)));
    expected[vertex] = static_cast<float>(i);
  }
  const auto content = queue.take();
  EXPECT_EQ(content.receptions[MeshMember::UPDATES].accepted, 1000u);
  ASSERT_EQ(content.changed_costs.size(), 1u);
  const auto& changed = content.changed_costs[0];
  EXPECT_EQ(changed.layer->costs, expected);
  EXPECT_EQ(changed.layer->summary.limits.upper, 999.0f);
  EXPECT_TRUE(changed.updates.empty()) << "so many that they are not told one by one";
  EXPECT_EQ(layer->costs, std::vector<float>(31)) << "the GUI thread may be reading it";
  queue.receive(update("slope", 3, -1.0f));
  EXPECT_EQ(changed.layer->costs, expected);
  expected[3] = -1.0f;
  EXPECT_EQ(queue.take().changed_costs.at(0).layer->costs, expected);
}

TEST(Inbox, few_updates_are_told_with_their_vertices_from_one_take_to_the_next)
{
  AttributeQueue queue;
  queue.receive(test_meshes::costs("slope", std::vector<float>(1000)));
  const auto layer = queue.take().costs.at(0);
  queue.receive(update("slope", 7, 1.0f));
  queue.receive(update("slope", 9, 2.0f));
  const auto first = queue.take().changed_costs.at(0);
  ASSERT_EQ(first.updates.size(), 2u);
  EXPECT_EQ(first.updates[1]->vertices, std::vector<std::uint32_t>{9});
  queue.receive(update("slope", 11, 3.0f));
  const auto second = queue.take().changed_costs.at(0);
  ASSERT_EQ(second.updates.size(), 1u);
  EXPECT_EQ(second.layer->costs[7], 1.0f);
  EXPECT_EQ(second.layer->costs[11], 3.0f);
  EXPECT_EQ(first.layer->costs[11], 0.0f) << "what was taken never changes";
}

TEST(Inbox, an_update_that_comes_to_nothing_takes_none_of_those_before_it_along)
{
  AttributeQueue queue;
  queue.receive(test_meshes::costs("slope", std::vector<float>(1000)));
  const auto layer = queue.take().costs.at(0);
  queue.receive(update("slope", 7, 1.0f));
  const std::atomic<bool> ended{true};
  EXPECT_FALSE(queue.receive(update("slope", 9, 2.0f), &ended));
  queue.receive(update("slope", 5000, 1.0f));
  const auto changed = queue.take().changed_costs;
  ASSERT_EQ(changed.size(), 1u);
  EXPECT_EQ(changed[0].layer->costs[7], 1.0f);
  queue.receive(update("slope", 11, 3.0f));
  EXPECT_EQ(queue.take().changed_costs.at(0).layer->costs[7], 1.0f);
}

TEST(Inbox, what_another_topic_of_updates_has_brought_stays_in_its_layer)
{
  AttributeQueue queue;
  queue.receive(test_meshes::costs("slope", std::vector<float>(1000)));
  queue.receive(update("slope", 6, 1.0f));
  queue.take();  // of which only what comes next is kept
  queue.receive(test_meshes::costs("slope", std::vector<float>(1000)));
  auto shown = queue.take().costs.at(0);
  queue.receive(update("slope", 7, 1.0f));
  shown.reset();
  queue.forget(MeshMember::UPDATES);
  queue.receive(update("slope", 9, 2.0f));
  const auto content = queue.take();
  EXPECT_EQ(content.receptions[MeshMember::UPDATES].accepted, 1u);
  EXPECT_EQ(content.receptions[MeshMember::UPDATES].refusal, "");
  ASSERT_EQ(content.changed_costs.size(), 1u);
  EXPECT_EQ(content.changed_costs[0].layer->costs[7], 1.0f);
  EXPECT_EQ(content.changed_costs[0].layer->costs[9], 2.0f);
}

TEST(Inbox, an_update_without_vertices_changes_no_layer)
{
  AttributeQueue queue;
  queue.receive(test_meshes::costs("slope", std::vector<float>(1000)));
  const auto layer = queue.take().costs.at(0);
  auto nothing = update("slope", 0, 0.0f);
  nothing.mesh_vertex_costs.vertices.clear();
  nothing.mesh_vertex_costs.costs.clear();
  EXPECT_TRUE(queue.receive(nothing));
  const auto content = queue.take();
  EXPECT_EQ(content.receptions[MeshMember::UPDATES].accepted, 1u);
  EXPECT_TRUE(content.changed_costs.empty());
}

TEST(Inbox, says_that_an_update_is_of_a_layer_that_nobody_has_any_more)
{
  AttributeQueue queue;
  queue.receive(test_meshes::costs("slope", std::vector<float>(1000)));
  queue.take();
  EXPECT_TRUE(queue.receive(update("slope", 7, 1.0f)));
  const auto content = queue.take();
  EXPECT_TRUE(content.changed_costs.empty());
  EXPECT_EQ(
      content.receptions[MeshMember::UPDATES].refusal,
      "layer 'slope' is not kept any more: its updates count from when it comes again, whole");
  queue.receive(test_meshes::costs("slope", std::vector<float>(1000)));
  EXPECT_TRUE(queue.receive(update("slope", 7, 1.0f)));
  EXPECT_EQ(queue.take().receptions[MeshMember::UPDATES].refusal, "");
}

TEST(Inbox, keeps_few_meshes_and_bytes_of_layers_and_textures_while_nobody_takes_them)
{
  const std::size_t bytes = rviz_mesh_plugin::ATTRIBUTE_BYTES;
  AttributeQueue queue(100 * bytes + 1000);
  for (int i = 0; i < 300; ++i) {
    queue.receive(test_meshes::colors({test_meshes::color(1, 0, 0)}, std::to_string(i)));
    queue.receive(test_meshes::costs(std::to_string(i), {1.0f}));
    queue.receive(texture(static_cast<std::uint32_t>(i / 2)));
  }
  const auto content = queue.take();
  ASSERT_EQ(content.colors.size(), 8u);
  EXPECT_EQ(content.colors.back()->uuid, "299");
  ASSERT_EQ(content.costs.size(), 100u);
  EXPECT_EQ(content.costs.front()->type, "200");
  ASSERT_EQ(content.textures.size(), 100u) << "of each index one";
  EXPECT_EQ(content.textures.front()->index, 50u);
  queue.receive(test_meshes::costs("small", {1.0f}));
  queue.receive(test_meshes::costs("large", std::vector<float>(24 * bytes)));
  queue.receive(test_meshes::costs("later", {1.0f}));
  EXPECT_EQ(queue.take().costs.size(), 3u) << "in all hardly too few";
  queue.receive(test_meshes::costs("small", {1.0f}));
  queue.receive(test_meshes::costs("large", std::vector<float>(26 * bytes)));
  const auto largest = queue.take();
  ASSERT_EQ(largest.costs.size(), 1u) << "the newest, whatever it takes";
  EXPECT_EQ(largest.costs.front()->type, "large");
}

TEST(Inbox, keeps_the_order_of_labels)
{
  AttributeQueue queue;
  queue.receive(cluster("tree_1", {1}));
  queue.receiveLabels("", {cluster("tree_2", {2}), cluster("tree_2", {3})}, true);
  queue.receive(cluster("tree_3", {4}));
  queue.receive(cluster("tree_2", {}));
  const auto labels = queue.take().labels;
  ASSERT_EQ(labels.size(), 3u) << "all labels replace those before";
  EXPECT_TRUE(labels[0]->all);
  ASSERT_EQ(labels[0]->clusters.size(), 1u) << "clusters of one label are joined";
  EXPECT_EQ(labels[0]->clusters[0].faces, (std::vector<std::uint32_t>{2, 3}));
  EXPECT_EQ(labels[1]->clusters[0].label, "tree_3");
  EXPECT_TRUE(labels[2]->clusters[0].faces.empty());
}

TEST(Inbox, joins_labels_that_nobody_takes)
{
  AttributeQueue queue;
  queue.receiveLabels("", {cluster("old", {9})}, true);
  for (std::uint32_t i = 0; i < 2000; ++i) {
    queue.receive(cluster("tree_" + std::to_string(i % 500), {i}));
  }
  const auto labels = queue.take().labels;
  EXPECT_LE(labels.size(), 256u);
  EXPECT_TRUE(labels[0]->all);
  std::map<std::string, std::vector<std::uint32_t>> faces;
  for (const auto& set : labels) {
    for (const auto& one : set->clusters) {
      faces[one.label] = one.faces;
    }
  }
  EXPECT_EQ(faces.size(), 501u);
  EXPECT_EQ(faces["tree_7"], std::vector<std::uint32_t>{1507});
}

TEST(Inbox, leaves_out_labels_that_cannot_be_used_and_says_so)
{
  AttributeQueue queue;
  EXPECT_TRUE(queue.receiveLabels(
      "mesh", {cluster("a/b", {1}), cluster("tree_1", {2}), cluster("", {3})}, true));
  EXPECT_FALSE(queue.receive(cluster("", {1})));
  queue.receiveLabels("mesh", {cluster("a/b", {1}), cluster("tree_1", {2})}, true);
  const auto content = queue.take();
  ASSERT_EQ(content.labels.size(), 1u);
  EXPECT_EQ(content.labels[0]->uuid, "mesh");
  ASSERT_EQ(content.labels[0]->clusters.size(), 1u);
  EXPECT_EQ(content.receptions[MeshMember::LABELS].refusal,
            "1 of 2 labels are left out: the label 'a/b' contains a slash; choose up to 255 bytes "
            "without '/', such as 'tree_1'");
  EXPECT_EQ(content.receptions[MeshMember::LABELS].accepted, 2u);
  EXPECT_EQ(content.receptions[MeshMember::LABELS].refused, 1u);
}

TEST(Inbox, refuses_labels_that_are_no_text)
{
  // Their names would be others in a property than they are.
  for (const char* label : {"tree_\xff", "\xc3", "tr\xc0\xa9", "\xed\xa0\x80", "a\xe2\x82"}) {
    AttributeQueue queue;
    EXPECT_FALSE(queue.receive(cluster(label, {1}))) << label;
    const std::string refusal = queue.take().receptions[MeshMember::LABELS].refusal;
    EXPECT_NE(refusal.find("is no UTF-8"), std::string::npos) << refusal;
  }
  AttributeQueue queue;
  EXPECT_TRUE(queue.receive(cluster("b\xc3\xa4ume_\xf0\x9f\x8c\xb3", {1})));
}

TEST(Inbox, drops_what_is_not_wanted_any_more_without_a_trace)
{
  AttributeQueue queue;
  const std::atomic<bool> dropped{true};
  EXPECT_FALSE(queue.receive(test_meshes::costs("slope", {1.0f}), &dropped));
  EXPECT_FALSE(queue.receive(texture(1), &dropped));
  EXPECT_FALSE(queue.receiveLabels("", {cluster("tree_1", {1})}, true, &dropped));
  const auto content = queue.take();
  EXPECT_TRUE(content.costs.empty() && content.textures.empty() && content.labels.empty());
  EXPECT_EQ(content.receptions[MeshMember::COSTS].received() +
                content.receptions[MeshMember::TEXTURES].received() +
                content.receptions[MeshMember::LABELS].received(),
            0u);
}

TEST(Inbox, counts_refusals_of_each_kind_with_their_reason)
{
  AttributeQueue queue;
  EXPECT_FALSE(queue.receive(faceCosts("slope", -std::numeric_limits<float>::infinity())));
  auto bad = update("slope", 0, 1.0f);
  bad.mesh_vertex_costs.costs.clear();
  EXPECT_FALSE(queue.receive(bad));
  auto broken = texture(0);
  broken.image.encoding = "jpeg";
  EXPECT_FALSE(queue.receive(broken));
  mesh_msgs::MeshMaterialsStamped materials;
  EXPECT_FALSE(queue.receive(materials));
  const auto content = queue.take();
  EXPECT_NE(content.receptions[MeshMember::FACE_COSTS].refusal.find("face 0 is -inf"),
            std::string::npos);
  EXPECT_NE(content.receptions[MeshMember::UPDATES].refusal.find("0 costs for 1 vertices"),
            std::string::npos);
  EXPECT_NE(content.receptions[MeshMember::TEXTURES].refusal.find("encoding 'jpeg'"),
            std::string::npos);
  EXPECT_NE(content.receptions[MeshMember::MATERIALS].refusal.find("frame_id"), std::string::npos);
  EXPECT_EQ(content.receptions[MeshMember::MATERIALS].refused, 1u);
  queue.receive(faceCosts("slope", 1.0f));
  queue.refuse(MeshMember::TEXTURES, "it ends in the middle");
  const auto later = queue.take();
  EXPECT_EQ(later.receptions[MeshMember::FACE_COSTS].refusal, "");
  EXPECT_EQ(later.receptions[MeshMember::FACE_COSTS].last_refusal,
            content.receptions[MeshMember::FACE_COSTS].refusal);
  EXPECT_EQ(later.receptions[MeshMember::TEXTURES].refusal, "it ends in the middle");
  EXPECT_EQ(later.receptions[MeshMember::TEXTURES].refused, 2u);
}

// The GUI thread takes and forgets while messages are joined with those before them.
TEST(Inbox, loses_and_repeats_nothing_that_is_taken_while_it_is_joined)
{
  constexpr std::uint32_t VERTICES = 20000;
  constexpr int UPDATES = 400;
  AttributeQueue queue;
  queue.receive(test_meshes::costs("slope", std::vector<float>(VERTICES, -1.0f)));
  std::thread sender([&] {
    mesh_msgs::MeshVertexCostsSparseStamped all = update("slope", 0, 0.0f);
    for (int i = 0; i < UPDATES; ++i) {
      all.mesh_vertex_costs.vertices.clear();
      for (std::uint32_t vertex = i % 7; vertex < VERTICES; vertex += 7) {
        all.mesh_vertex_costs.vertices.push_back(vertex);
      }
      all.mesh_vertex_costs.costs.assign(all.mesh_vertex_costs.vertices.size(), float(i));
      queue.receive(all);
      queue.receive(texture(static_cast<std::uint32_t>(i)));
    }
  });
  auto layer = rviz_mesh_plugin::CostLayerConstPtr();  // is in use
  std::vector<float> costs(VERTICES, -1.0f);
  std::set<std::uint32_t> textures;
  std::size_t received = 0;
  while (received < UPDATES) {
    const auto content = queue.take();
    received = content.receptions[MeshMember::TEXTURES].accepted;
    layer = content.costs.empty() ? layer : content.costs.front();
    for (const auto& one : content.changed_costs) {
      layer = one.layer;
      for (std::uint32_t vertex = 0; vertex < VERTICES; ++vertex) {
        EXPECT_GE(one.layer->costs[vertex], costs[vertex]);
      }
      costs = one.layer->costs;
    }
    for (const auto& one : content.textures) {
      EXPECT_TRUE(textures.insert(one->index).second);
    }
    queue.forget(MeshMember::LABELS);
  }
  sender.join();
  EXPECT_EQ(textures.size(), std::size_t(UPDATES));
  for (std::uint32_t vertex = 0; vertex < VERTICES; ++vertex) {
    const int last = UPDATES - 1 - (UPDATES - 1 - int(vertex % 7)) % 7;
    ASSERT_EQ(costs[vertex], float(last)) << vertex;
  }
}
