#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "meshes.h"
#include "rviz_mesh_plugin/mesh_conversion.h"
#include "rviz_mesh_plugin/mesh_inbox.h"
#include "rviz_mesh_plugin/mesh_store.h"

using rviz_mesh_plugin::convert;
using rviz_mesh_plugin::MeshInbox;
using rviz_mesh_plugin::MeshStore;

namespace {

rviz_mesh_plugin::MeshDataConstPtr mesh(const std::string& uuid)
{
  auto message = test_meshes::square();
  message.uuid = uuid;
  return convert(message);
}

}  // namespace

TEST(MeshStore, keeps_costs_and_colors_until_their_geometry_comes)
{
  MeshStore store;
  store.addCosts(convert(test_meshes::costs("roughness", {1, 2, 3, 4}, "a")));
  store.addCosts(convert(test_meshes::costs("height", {5, 6, 7, 8}, "b")));
  store.addColors(convert(test_meshes::colors({test_meshes::color(1, 0, 0)}, "b")));
  EXPECT_TRUE(store.costTypes().empty());
  EXPECT_EQ(store.waitingCosts(), 2u);
  EXPECT_EQ(store.waitingColors(), 1u);
  store.setGeometry(mesh("b"));
  EXPECT_EQ(store.costTypes(), (std::vector<std::string>{"height"}));
  ASSERT_TRUE(store.costs("height"));
  EXPECT_EQ(store.costs("height")->costs, (std::vector<float>{5, 6, 7, 8}));
  EXPECT_FALSE(store.costs("roughness")) << "belongs to the other mesh";
  EXPECT_TRUE(store.colors());
  EXPECT_EQ(store.waitingCosts(), 1u);
  EXPECT_EQ(store.waitingColors(), 0u);
  store.setGeometry(mesh("a"));
  EXPECT_EQ(store.costTypes(), (std::vector<std::string>{"roughness"}));
  EXPECT_FALSE(store.colors());
}

TEST(MeshStore, replaces_a_layer_in_its_place)
{
  MeshStore store;
  store.setGeometry(mesh("a"));
  for (const char* type : {"first", "second", "first"}) {
    store.addCosts(convert(test_meshes::costs(type, {float(store.costTypes().size())}, "a")));
  }
  EXPECT_EQ(store.costTypes(), (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(store.costs("first")->costs, (std::vector<float>{2.0f}));
}

TEST(MeshStore, forgets_the_oldest_beyond_its_bounds_but_never_those_of_the_mesh_shown)
{
  MeshStore store;
  store.setGeometry(mesh("shown"));
  store.addCosts(convert(test_meshes::costs("kept", {1}, "shown")));
  for (std::size_t i = 0; i < 3 * MeshStore::MAX_MESHES; ++i) {
    store.addCosts(convert(test_meshes::costs("x", {1}, "other " + std::to_string(i))));
  }
  EXPECT_TRUE(store.costs("kept"));
  EXPECT_EQ(store.waitingCosts(), MeshStore::MAX_MESHES - 1);
  for (std::size_t i = 0; i < 2 * MeshStore::MAX_LAYERS; ++i) {
    store.addCosts(convert(test_meshes::costs("layer " + std::to_string(i), {1}, "shown")));
  }
  EXPECT_EQ(store.costTypes().size(), MeshStore::MAX_LAYERS);
  EXPECT_TRUE(store.costs("layer " + std::to_string(2 * MeshStore::MAX_LAYERS - 1)));
}

TEST(MeshStore, clears_each_kind_on_its_own)
{
  MeshStore store;
  store.setGeometry(mesh("a"));
  store.addCosts(convert(test_meshes::costs("x", {1}, "a")));
  store.addColors(convert(test_meshes::colors({test_meshes::color(1, 0, 0)}, "a")));
  store.clearCosts();
  EXPECT_FALSE(store.costs("x"));
  EXPECT_TRUE(store.colors());
  store.clearColors();
  EXPECT_FALSE(store.colors());
  EXPECT_TRUE(store.geometry());
  store.clear();
  EXPECT_FALSE(store.geometry());
}

TEST(MeshInbox, hands_over_the_newest_of_each_kind_once)
{
  MeshInbox inbox;
  for (const float value : {1.0f, 2.0f}) {
    inbox.receive(test_meshes::square(value));
    inbox.receive(test_meshes::costs("x", {value}));
    inbox.receive(test_meshes::costs("y", {value}));
    inbox.receive(test_meshes::colors({test_meshes::color(value / 2, 0, 0)}));
  }
  auto content = inbox.take();
  ASSERT_TRUE(content.geometry);
  EXPECT_EQ(content.geometry->vertices[0].position[2], 2.0f);
  ASSERT_EQ(content.costs.size(), 2u);
  EXPECT_EQ(content.costs[0]->type, "x");
  EXPECT_EQ(content.costs[0]->costs[0], 2.0f);
  ASSERT_EQ(content.colors.size(), 1u);
  EXPECT_EQ(content.colors[0]->colors[0].red, 255);
  EXPECT_EQ(content.costs_reception.accepted, 4u);
  content = inbox.take();
  EXPECT_FALSE(content.geometry);
  EXPECT_TRUE(content.costs.empty());
  EXPECT_TRUE(content.colors.empty());
  EXPECT_EQ(content.geometry_reception.accepted, 2u) << "goes on counting";
}

TEST(MeshInbox, keeps_the_last_good_mesh_and_tells_why_the_newest_message_was_refused)
{
  MeshInbox inbox;
  auto bad = test_meshes::square();
  bad.mesh_geometry.faces[0].vertex_indices[0] = 77;
  inbox.receive(test_meshes::square());
  inbox.receive(bad);
  auto content = inbox.take();
  EXPECT_TRUE(content.geometry);
  EXPECT_EQ(content.geometry_reception.accepted, 1u);
  EXPECT_EQ(content.geometry_reception.refused, 1u);
  EXPECT_NE(content.geometry_reception.refusal.find("refers to vertex 77"), std::string::npos);
  inbox.receive(test_meshes::square());
  content = inbox.take();
  EXPECT_EQ(content.geometry_reception.refusal, "") << "the newest message was good";
  EXPECT_EQ(content.geometry_reception.refused, 1u);
}

TEST(MeshInbox, loses_nothing_between_two_threads)
{
  constexpr std::size_t LAYERS = 2000;
  MeshInbox inbox;
  std::thread sender([&] {
    for (std::size_t i = 0; i < LAYERS; ++i) {
      inbox.receive(test_meshes::costs(std::to_string(i), {float(i)}));
    }
  });
  std::vector<std::string> types;
  std::size_t accepted = 0;
  while (accepted < LAYERS) {
    const auto content = inbox.take();
    accepted = content.costs_reception.accepted;
    for (const auto& layer : content.costs) {
      types.push_back(layer->type);
    }
    std::this_thread::yield();
  }
  sender.join();
  ASSERT_EQ(types.size(), LAYERS);
  for (std::size_t i = 0; i < LAYERS; ++i) {
    EXPECT_EQ(types[i], std::to_string(i));
  }
}
