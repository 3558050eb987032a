#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "conversion/attribute_conversion.h"
#include "conversion/mesh_conversion.h"
#include "incoming/attribute_queue.h"
#include "incoming/cost_order.h"
#include "incoming/mesh_store.h"
#include "mesh_view/mesh_appearance.h"
#include "support/meshes.h"

using rviz_mesh_plugin::AttributeQueue;
using rviz_mesh_plugin::convert;
using rviz_mesh_plugin::CostLayer;
using rviz_mesh_plugin::CostLayerConstPtr;
using rviz_mesh_plugin::CostUpdate;
using rviz_mesh_plugin::CostUpdateConstPtr;
using rviz_mesh_plugin::LabelCluster;
using rviz_mesh_plugin::LabelSet;
using rviz_mesh_plugin::LabelSetConstPtr;
using rviz_mesh_plugin::MeshMember;
using rviz_mesh_plugin::MeshStore;

namespace {

rviz_mesh_plugin::MeshDataConstPtr mesh(const std::string& uuid)
{
  auto message = test_meshes::square();
  message.uuid = uuid;
  return convert(message);
}

CostUpdateConstPtr update(const std::string& type, const std::vector<std::uint32_t>& vertices,
                          const std::vector<float>& costs)
{
  return std::make_shared<CostUpdate>(CostUpdate{"a", type, vertices, costs, 0});
}

LabelSetConstPtr labels(const std::string& uuid, bool all,
                        const std::vector<LabelCluster>& clusters)
{
  return std::make_shared<LabelSet>(LabelSet{uuid, all, clusters});
}

}  // namespace

TEST(MeshStore, keeps_costs_and_colors_until_their_geometry_comes)
{
  MeshStore store;
  store.addCosts(convert(test_meshes::costs("roughness", {1, 2, 3, 4}, "a")));
  store.addCosts(convert(test_meshes::costs("height", {5, 6, 7, 8}, "b")));
  store.addColors(convert(test_meshes::colors({test_meshes::color(1, 0, 0)}, "b")));
  EXPECT_TRUE(store.costTypes().empty());
  EXPECT_EQ(store.waitingCosts().count, 2u);
  EXPECT_EQ(store.waitingColors().count, 1u);
  store.addMesh(mesh("b"));
  EXPECT_EQ(store.costTypes(), (std::vector<std::string>{"height"}));
  ASSERT_TRUE(store.attributes().cost("height"));
  EXPECT_EQ(store.attributes().cost("height")->costs, (std::vector<float>{5, 6, 7, 8}));
  EXPECT_FALSE(store.attributes().cost("roughness")) << "belongs to the other mesh";
  EXPECT_TRUE(store.attributes().colors);
  EXPECT_EQ(store.waitingCosts().count, 1u);
  EXPECT_EQ(store.waitingColors().count, 0u);
  store.addMesh(mesh("a"));
  EXPECT_EQ(store.costTypes(), (std::vector<std::string>{"roughness"}));
  EXPECT_FALSE(store.attributes().colors);
}

TEST(MeshStore, replaces_a_layer_in_its_place)
{
  MeshStore store;
  store.addMesh(mesh("a"));
  for (const char* type : {"first", "second", "first"}) {
    store.addCosts(convert(test_meshes::costs(type, {float(store.costTypes().size())}, "a")));
  }
  EXPECT_EQ(store.costTypes(), (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(store.attributes().cost("first")->costs, (std::vector<float>{2.0f}));
}

TEST(MeshStore, forgets_the_oldest_beyond_its_bounds_but_never_those_of_the_mesh_shown)
{
  MeshStore store;
  store.addMesh(mesh("shown"));
  store.addCosts(convert(test_meshes::costs("kept", {1}, "shown")));
  store.addCosts(convert(test_meshes::costs("first", {1}, "often")));
  for (std::size_t i = 0; i < 3 * MeshStore::MAX_WAITING; ++i) {
    store.addCosts(convert(test_meshes::costs("x", {1}, "other " + std::to_string(i))));
    store.addCosts(convert(test_meshes::costs("x", {1}, "often")));
  }
  EXPECT_TRUE(store.attributes().cost("kept"));
  EXPECT_TRUE(store.attributes("often").cost("first"))
      << "the oldest is what has not come for longest";
  EXPECT_EQ(store.waitingCosts().count, MeshStore::MAX_WAITING + 1);
}

TEST(MeshStore, keeps_so_many_bytes_of_layers)
{
  MeshStore store(10 * rviz_mesh_plugin::ATTRIBUTE_BYTES + 1000);
  store.addMesh(mesh("shown"));
  for (int i = 0; i < 20; ++i) {
    store.addCosts(convert(test_meshes::costs("layer " + std::to_string(i), {1}, "shown")));
  }
  EXPECT_EQ(store.costTypes().size(), 10u);
  EXPECT_EQ(store.costTypes().front(), "layer 10");
  EXPECT_EQ(store.attributes().costs_left_out.size(), 10u);
  EXPECT_TRUE(store.attributes().leftOut("layer 9"));
  EXPECT_FALSE(store.attributes().leftOut("layer 10"));
  store.addCosts(convert(test_meshes::costs("layer 15", {2}, "shown")));
  EXPECT_EQ(store.costTypes().size(), 10u) << "in its place";
  const std::vector<float> many(3 * rviz_mesh_plugin::ATTRIBUTE_BYTES);
  store.addCosts(convert(test_meshes::costs("large", many, "shown")));
  EXPECT_EQ(store.costTypes(), std::vector<std::string>{"large"}) << "the newest in any case";
  store.addCosts(convert(test_meshes::costs("layer 3", {1}, "shown")));
  EXPECT_FALSE(store.attributes().leftOut("layer 3"));
  EXPECT_TRUE(store.attributes().leftOut("large"));
  store.forget(MeshMember::FACE_COSTS);
  EXPECT_TRUE(store.attributes().leftOut("large"));
  store.forget(MeshMember::COSTS);
  EXPECT_TRUE(store.attributes().costs_left_out.empty());
}

TEST(MeshStore, clears_each_kind_on_its_own)
{
  MeshStore store;
  store.addMesh(mesh("a"));
  store.addCosts(convert(test_meshes::costs("x", {1}, "a")));
  store.addColors(convert(test_meshes::colors({test_meshes::color(1, 0, 0)}, "a")));
  store.forget(MeshMember::FACE_COSTS);
  EXPECT_TRUE(store.attributes().cost("x")) << "it is one of vertices";
  store.forget(MeshMember::COSTS);
  EXPECT_FALSE(store.attributes().cost("x"));
  EXPECT_TRUE(store.attributes().colors);
  store.forget(MeshMember::COLORS);
  EXPECT_FALSE(store.attributes().colors);
  EXPECT_TRUE(store.newest());
  store.clear();
  EXPECT_FALSE(store.newest());
}

TEST(MeshStore, knows_what_the_layers_of_one_geometry_mean)
{
  mesh_msgs::LayerInfoArray message;
  message.uuid = "a";
  message.layers.resize(4);
  message.layers[0].name = "steepness";
  message.layers[0].layer_type = "mesh_layers/SteepnessLayer";
  message.layers[0].unit = "rad";
  message.layers[0].comparison = mesh_msgs::LayerInfo::ABOVE;
  message.layers[0].threshold = 0.5f;
  message.layers[1].name = "clearance";
  message.layers[1].comparison = mesh_msgs::LayerInfo::AT_LEAST;
  message.layers[1].threshold = 1.0f;
  message.layers[2].name = "of a later release";
  message.layers[2].comparison = 200;
  message.layers[2].threshold = 1.0f;
  message.layers[2].lethal = 7;
  message.layers[3].name = "steepness";  // once more
  MeshStore store;
  store.setLayerInfos(message.uuid, convert(message));
  const auto& steepness = store.layerInfo("a", "steepness");
  EXPECT_EQ(lethalRule(steepness), "lethal above 0.5 rad");
  EXPECT_FALSE(steepness.isLethal(0.5f));
  EXPECT_TRUE(steepness.isLethal(std::nextafter(0.5f, 1.0f)));
  EXPECT_FALSE(steepness.isLethal(std::nanf("")));
  const auto& clearance = store.layerInfo("a", "clearance");
  EXPECT_EQ(lethalRule(clearance), "lethal from 1");
  EXPECT_TRUE(clearance.isLethal(1.0f));
  EXPECT_FALSE(clearance.isLethal(std::nextafter(1.0f, 0.0f)));
  EXPECT_EQ(clearance.infinity, "lethal");
  const auto& later = store.layerInfo("a", "of a later release");
  EXPECT_EQ(later.comparison, rviz_mesh_plugin::LayerInfo::OTHER);
  EXPECT_EQ(lethalRule(later), "");
  constexpr float INFINITE = std::numeric_limits<float>::infinity();
  for (const auto* other :
       {&later, &store.layerInfo("b", "steepness"), &store.layerInfo("a", "")}) {
    EXPECT_FALSE(other->isLethal(std::numeric_limits<float>::max()));
    EXPECT_TRUE(other->isLethal(INFINITE));
  }
  store.clear();
  EXPECT_EQ(lethalRule(store.layerInfo("a", "steepness")), "");
}

TEST(MeshStore, keeps_the_newest_meshes_up_to_its_capacity)
{
  MeshStore store;
  store.setCapacity(2);
  for (const char* uuid : {"a", "b", "a", "c"}) {
    store.addMesh(mesh(uuid));
  }
  ASSERT_EQ(store.meshes().size(), 2u);
  EXPECT_EQ(store.meshes()[0]->uuid, "c");
  EXPECT_EQ(store.meshes()[1]->uuid, "a") << "b is the oldest: a came again";
  EXPECT_EQ(store.newest(), store.mesh("c"));
  EXPECT_FALSE(store.mesh("b"));
  store.setCapacity(0);
  EXPECT_EQ(store.meshes().size(), 1u);
  EXPECT_EQ(store.newest()->uuid, "c");
}

TEST(MeshStore, lists_the_layers_of_all_meshes_and_tells_those_of_faces_apart)
{
  MeshStore store;
  store.setCapacity(2);
  store.addMesh(mesh("a"));
  store.addMesh(mesh("b"));
  store.addCosts(convert(test_meshes::costs("only a", {1}, "a")));
  store.addCosts(convert(test_meshes::costs("both", {1}, "a")));
  store.addCosts(convert(test_meshes::costs("both", {2}, "b")));
  for (const char* type : {"both", "of faces"}) {
    auto layer = std::make_shared<CostLayer>();
    layer->uuid = "b";
    layer->type = type;
    layer->on_faces = true;
    layer->costs = {7};
    store.addCosts(layer);
  }
  EXPECT_EQ(store.costTypes(),
            (std::vector<std::string>{"both", "both (faces)", "of faces", "only a"}));
  EXPECT_EQ(store.attributes("b").cost("both")->costs[0], 2.0f);
  EXPECT_EQ(store.attributes("b").cost("both (faces)")->costs[0], 7.0f);
  EXPECT_TRUE(store.attributes("b").cost("of faces")->on_faces);
  EXPECT_FALSE(store.attributes("a").cost("both (faces)"));
}

TEST(MeshStore, a_layer_that_updates_have_changed_takes_its_place)
{
  MeshStore store;
  store.addCosts(convert(test_meshes::costs("x", {1, 2, 3, 4}, "a")));
  store.addCosts(convert(test_meshes::costs("y", {1, 2, 3, 4}, "a")));
  const CostLayerConstPtr changed = convert(test_meshes::costs("x", {1, 2, 9, 4}, "a"));
  EXPECT_TRUE(store.changeCosts(changed));
  EXPECT_EQ(store.attributes("a").cost("x"), changed);
  EXPECT_EQ(store.attributes("a").costs.front(), changed) << "in its place";
  EXPECT_FALSE(store.changeCosts(convert(test_meshes::costs("z", {1, 2, 9, 4}, "a"))));
  EXPECT_FALSE(store.changeCosts(convert(test_meshes::costs("x", {1, 2}, "a"))))
      << "made of another one, which has been dropped on the way";
  EXPECT_EQ(store.attributes("a").costs.size(), 2u);
}

TEST(MeshStore, updates_of_other_meshes_drive_nothing_out_that_waits)
{
  MeshStore store;
  store.addColors(convert(test_meshes::colors({test_meshes::color(1, 0, 0)}, "a")));
  for (std::size_t i = 0; i < 2 * MeshStore::MAX_WAITING; ++i) {
    store.changeCosts(convert(test_meshes::costs("x", {1}, "other " + std::to_string(i))));
  }
  store.addMesh(mesh("a"));
  EXPECT_TRUE(store.attributes().colors);
}

TEST(MeshStore, keeps_so_many_bytes_of_textures)
{
  MeshStore store;
  for (std::uint32_t i = 0; i < 50; ++i) {
    auto texture = std::make_shared<rviz_mesh_plugin::TextureImage>();
    texture->uuid = "a";
    texture->index = i;
    texture->width = texture->height = 8192;  // with mipmaps 358 MB
    store.addTexture(texture);
  }
  const auto& textures = store.attributes("a").textures;
  EXPECT_EQ(textures.size(), 5u) << "of 2 GiB";
  EXPECT_EQ(textures.rbegin()->first, 4u) << "those of lowest index";
  EXPECT_EQ(store.attributes("a").textures_left_out.size(), 45u);
  EXPECT_EQ(store.attributes("a").textures_left_out.count(4), 0u);
  auto small = std::make_shared<rviz_mesh_plugin::TextureImage>();
  small->uuid = "a";
  small->index = 7;
  small->width = small->height = 1;
  store.addTexture(small);
  EXPECT_EQ(store.attributes("a").textures_left_out.size(), 44u) << "it has come again, and fits";
  store.forget(MeshMember::MATERIALS);
  EXPECT_TRUE(store.attributes("a").textures_left_out.empty());
}

TEST(CostUpdate, limits_of_a_large_layer_widen_and_its_counts_stay_exact)
{
  CostLayer layer;
  layer.costs.assign(rviz_mesh_plugin::MAX_SUMMARIZED_AGAIN + 1, 1.0f);
  layer.summary = rviz_mesh_plugin::summarizeCosts(layer.costs);
  EXPECT_EQ(applyUpdate(layer, *update("x", {0, 1, 2, 3}, {-5, INFINITY, NAN, 0.5f})), "");
  EXPECT_EQ(layer.summary.limits.lower, -5.0f);
  EXPECT_EQ(layer.summary.limits.upper, 1.0f);
  EXPECT_EQ(layer.summary.finite, layer.costs.size() - 2);
  EXPECT_EQ(layer.summary.lethal, 1u);
  EXPECT_EQ(layer.summary.unknown, 1u);
  EXPECT_EQ(layer.summary.positive, layer.costs.size() - 3);
  EXPECT_EQ(layer.summary.least_positive, 0.5f);
  EXPECT_EQ(applyUpdate(layer, *update("x", {0}, {2})), "");
  EXPECT_EQ(layer.summary.limits.lower, -5.0f) << "does not become narrower";
  layer.costs.assign(3, NAN);
  layer.summary = rviz_mesh_plugin::summarizeCosts(layer.costs);
  EXPECT_EQ(applyUpdate(layer, *update("x", {1}, {-2})), "");
  EXPECT_EQ(layer.summary.limits.lower, -2.0f);
  EXPECT_EQ(layer.summary.limits.upper, -2.0f);
}

TEST(MeshStore, labels_come_one_by_one_or_all_at_once_and_before_their_mesh)
{
  MeshStore store;
  store.addLabels(labels("", false, {{"tree_1", {0, 1}}}));
  store.addMesh(mesh("a"));
  EXPECT_EQ(store.attributes().labels.count("tree_1"), 1u) << "of the only mesh";
  store.addLabels(labels("a", false, {{"tree_2", {1}}, {"tree_1", {0}}}));
  ASSERT_EQ(store.attributes().labels.size(), 2u);
  EXPECT_EQ(store.attributes().labels.at("tree_1")->faces, (std::vector<std::uint32_t>{0}));
  store.addLabels(labels("a", false, {{"tree_1", {}}}));
  EXPECT_EQ(store.attributes().labels.count("tree_1"), 0u) << "without faces it is gone";
  store.addLabels(labels("a", true, {{"house_1", {0}}}));
  EXPECT_EQ(store.attributes().labels.size(), 1u);
  EXPECT_EQ(store.attributes().labels.count("house_1"), 1u);
}

TEST(ShownCosts, automatic_limits_span_all_meshes_and_custom_ones_stay)
{
  MeshStore store;
  store.setCapacity(2);
  store.addMesh(mesh("a"));
  store.addMesh(mesh("b"));
  store.addCosts(convert(test_meshes::costs("x", {1, 5}, "a")));
  store.addCosts(convert(test_meshes::costs("x", {-3, INFINITY}, "b")));
  store.addCosts(convert(test_meshes::costs("x", {100, 200}, "not shown")));
  rviz_mesh_plugin::CostColoring coloring;
  const auto common = rviz_mesh_plugin::commonColoring(store, "x", coloring);
  EXPECT_EQ(common.limits.lower, -3.0f);
  EXPECT_EQ(common.limits.upper, 5.0f);
  coloring.custom_limits = true;
  coloring.limits = {2, 3};
  EXPECT_EQ(rviz_mesh_plugin::commonColoring(store, "x", coloring), coloring);
}

TEST(AttributeQueue, hands_over_the_newest_of_each_kind_once)
{
  AttributeQueue queue;
  for (const float value : {1.0f, 2.0f}) {
    queue.receive(test_meshes::costs("x", {value}));
    queue.receive(test_meshes::costs("y", {value}));
    queue.receive(test_meshes::colors({test_meshes::color(value / 2, 0, 0)}));
  }
  auto content = queue.take();
  ASSERT_EQ(content.costs.size(), 2u);
  EXPECT_EQ(content.costs[0]->type, "x");
  EXPECT_EQ(content.costs[0]->costs[0], 2.0f);
  ASSERT_EQ(content.colors.size(), 1u);
  EXPECT_EQ(content.colors[0]->colors[0].red, 255);
  EXPECT_EQ(content.receptions[MeshMember::COSTS].accepted, 4u);
  content = queue.take();
  EXPECT_TRUE(content.costs.empty());
  EXPECT_TRUE(content.colors.empty());
  EXPECT_EQ(content.receptions[MeshMember::COSTS].accepted, 4u) << "goes on counting";
}

TEST(AttributeQueue, loses_nothing_between_two_threads)
{
  constexpr std::size_t LAYERS = 250;  // as many as wait at once
  AttributeQueue queue;
  std::thread sender([&] {
    for (std::size_t i = 0; i < LAYERS; ++i) {
      queue.receive(test_meshes::costs(std::to_string(i), {float(i)}));
    }
  });
  std::vector<std::string> types;
  std::size_t accepted = 0;
  while (accepted < LAYERS) {
    const auto content = queue.take();
    accepted = content.receptions[MeshMember::COSTS].accepted;
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
