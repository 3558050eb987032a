#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>

#include "incoming/attribute_queue.h"
#include "incoming/cost_order.h"
#include "incoming/mesh_store.h"
#include "support/meshes.h"

using rviz_mesh_plugin::AttributeQueue;
using rviz_mesh_plugin::CostLayer;
using rviz_mesh_plugin::CostOrder;
using rviz_mesh_plugin::CostUpdate;
using rviz_mesh_plugin::CostUpdateConstPtr;
using rviz_mesh_plugin::MeshMember;
using rviz_mesh_plugin::MeshStore;

namespace {

using Values = std::vector<float>;

constexpr std::uint32_t VERTICES = 5;

ros::Time stamp(std::uint32_t seconds)
{
  return ros::Time(seconds, 0);
}

mesh_msgs::MeshVertexCostsStamped layer(std::uint32_t seconds, const Values& costs)
{
  auto message = test_meshes::costs("x", costs);
  message.header.stamp = stamp(seconds);
  return message;
}

mesh_msgs::MeshVertexCostsSparseStamped update(std::uint32_t seconds,
                                               const std::vector<std::uint32_t>& vertices,
                                               const Values& costs)
{
  mesh_msgs::MeshVertexCostsSparseStamped message;
  message.header.frame_id = "map";
  message.header.stamp = stamp(seconds);
  message.uuid = "mesh";
  message.type = "x";
  message.mesh_vertex_costs.vertices = vertices;
  message.mesh_vertex_costs.costs = costs;
  return message;
}

/// The queue and the store as a display uses them.
class Pipeline
{
 public:
  template <class Message>
  Pipeline& operator<<(const Message& message)
  {
    EXPECT_TRUE(queue_.receive(message));
    return *this;
  }

  Pipeline& frame()
  {
    const auto content = queue_.take();
    for (const auto& one : content.costs) {
      store_.addCosts(one);
    }
    for (const auto& one : content.changed_costs) {
      store_.changeCosts(one.layer);
    }
    stale_ = content.stale;
    EXPECT_EQ(content.receptions[MeshMember::UPDATES].refusal, "");
    return *this;
  }

  Values costs()
  {
    frame();
    const auto found = store_.attributes("mesh").cost("x");
    return found ? found->costs : Values();
  }

  std::size_t stale() const { return stale_; }

 private:
  AttributeQueue queue_;
  MeshStore store_;
  std::size_t stale_ = 0;
};

/// What costs should be after each message, vertex by vertex.
class Reference
{
 public:
  void operator<<(const mesh_msgs::MeshVertexCostsStamped& message)
  {
    stamp_ = message.header.stamp;
    costs_ = message.mesh_vertex_costs.costs;
    for (auto one = newer_.begin(); one != newer_.end();) {
      const bool counts = !stamp_->isZero() && one->second.stamp > *stamp_;
      one = counts ? std::next(one) : newer_.erase(one);
    }
  }

  void operator<<(const mesh_msgs::MeshVertexCostsSparseStamped& message)
  {
    const ros::Time now = message.header.stamp;
    if (stamp_ && !now.isZero() && now < *stamp_) {
      return;
    }
    const auto& changes = message.mesh_vertex_costs;
    for (std::size_t i = 0; i < changes.vertices.size(); ++i) {
      const auto known = newer_.find(changes.vertices[i]);
      if (known == newer_.end() || now >= known->second.stamp) {
        newer_[changes.vertices[i]] = {now, changes.costs[i]};
      }
    }
  }

  Values costs() const
  {
    Values all = costs_;
    for (const auto& one : newer_) {
      if (stamp_) {
        all[one.first] = one.second.cost;
      }
    }
    return all;
  }

 private:
  struct Change
  {
    ros::Time stamp;
    float cost;
  };
  std::optional<ros::Time> stamp_;
  Values costs_;
  std::map<std::uint32_t, Change> newer_;  ///< by vertex
};

}  // namespace

// Each sequence of messages in one frame, and in a frame each.
TEST(CostOrder, stamps_decide_and_without_them_the_order_of_arrival)
{
  const Values old(VERTICES, 1.0f);
  const Values fresh(VERTICES, 2.0f);
  const Values changed = {2, 9, 2, 2, 2};
  struct Case
  {
    const char* what;
    std::uint32_t update_stamp;
    std::uint32_t layer_stamp;
    bool update_first;
    Values expected;
    std::size_t stale;
  };
  const Case cases[] = {
      {"an older update after the layer", 5, 6, false, fresh, 1},
      {"an older update before the layer", 5, 6, true, fresh, 0},
      {"a newer update after the layer", 7, 6, false, changed, 0},
      {"a newer update that has overtaken the layer", 7, 6, true, changed, 0},
      {"equally new, the update last", 6, 6, false, changed, 0},
      {"equally new, the layer last", 6, 6, true, fresh, 0},
      {"no stamps, the update last", 0, 0, false, changed, 0},
      {"no stamps, the layer last", 0, 0, true, fresh, 0},
      {"an update without a stamp last", 0, 6, false, changed, 0},
      {"an update without a stamp first", 0, 6, true, fresh, 0},
      {"a layer without a stamp, the update last", 7, 0, false, changed, 0},
      {"a layer without a stamp last", 7, 0, true, fresh, 0},
  };
  for (const Case& one : cases) {
    for (const bool known : {false, true}) {  // whether there was a layer before
      for (const bool together : {false, true}) {
        SCOPED_TRACE(std::string(one.what) + (known ? ", known" : "") +
                     (together ? ", together" : ""));
        Pipeline pipeline;
        if (known) {
          pipeline << layer(1, old);
          pipeline.frame();
        }
        for (const bool first : {true, false}) {
          if (first == one.update_first) {
            pipeline << update(one.update_stamp, {1}, {9});
          } else {
            pipeline << layer(one.layer_stamp, fresh);
          }
          if (!together) {
            pipeline.frame();
          }
        }
        EXPECT_EQ(pipeline.costs(), one.expected);
        EXPECT_EQ(pipeline.stale(), one.stale);
      }
    }
  }
}

TEST(CostOrder, an_update_counts_vertex_by_vertex)
{
  Pipeline pipeline;
  pipeline << layer(1, {0, 0, 0, 0, 0}) << update(9, {1}, {9}) << update(5, {1, 2}, {5, 5});
  EXPECT_EQ(pipeline.costs(), (Values{0, 9, 5, 0, 0})) << "vertex 1 has got newer costs";
  pipeline << layer(7, {7, 7, 7, 7, 7});
  EXPECT_EQ(pipeline.costs(), (Values{7, 9, 7, 7, 7}));
  pipeline << layer(9, {8, 8});
  EXPECT_EQ(pipeline.costs(), (Values{8, 8})) << "another number of vertices";
}

TEST(CostOrder, an_older_layer_that_comes_last_replaces_a_newer_one)
{
  Pipeline pipeline;  // as when a recording begins anew
  pipeline << layer(100, {1, 1}) << update(101, {0}, {9}) << layer(101, {2, 2});
  EXPECT_EQ(pipeline.costs(), (Values{2, 2}));
  pipeline << layer(3, {4, 4}) << update(2, {0}, {7}) << update(3, {1}, {5});
  EXPECT_EQ(pipeline.costs(), (Values{4, 5}));
}

// The result is that of handling one message after the other, however they fall into frames, and
// however many of them the queue has to join.
TEST(CostOrder, is_that_of_messages_one_by_one)
{
  std::mt19937 random(7);
  const auto below = [&](std::uint32_t limit) {
    return std::uniform_int_distribution<std::uint32_t>(0, limit - 1)(random);
  };
  float next = 0.0f;
  for (int round = 0; round < 4000; ++round) {
    const bool stamped = below(4) != 0;          // updates
    const std::uint32_t layers = 2 + below(40);  // one message in so many is a layer
    const std::uint32_t pause = 1 + below(60);   // as many in a frame
    Pipeline pipeline;
    Reference reference;
    for (std::uint32_t i = 0; i < 80; ++i) {
      if (below(layers) == 0) {
        Values costs(VERTICES);
        std::generate(costs.begin(), costs.end(), [&] { return ++next; });
        const auto message = layer(below(12), costs);
        pipeline << message;
        reference << message;
      } else {
        std::vector<std::uint32_t> vertices;
        Values costs;
        for (std::uint32_t left = 1 + below(3); left > 0; --left) {
          vertices.push_back(below(VERTICES));
          costs.push_back(++next);
        }
        const auto message = update(stamped ? 1 + below(12) : 0, vertices, costs);
        pipeline << message;
        reference << message;
      }
      if (below(pause) == 0) {
        ASSERT_EQ(pipeline.costs(), reference.costs()) << "round " << round << ", message " << i;
      }
    }
    ASSERT_EQ(pipeline.costs(), reference.costs()) << "round " << round;
  }
}

namespace {

CostUpdateConstPtr made(const std::string& type, const std::vector<std::uint32_t>& vertices,
                        const Values& costs, std::uint64_t stamp)
{
  return std::make_shared<CostUpdate>(CostUpdate{"a", type, vertices, costs, stamp});
}

CostLayer madeLayer(const std::string& uuid, const Values& costs, std::uint64_t stamp)
{
  CostLayer layer;
  layer.uuid = uuid;
  layer.type = "x";
  layer.costs = costs;
  layer.stamp = stamp;
  return layer;
}

}  // namespace

TEST(CostOrder, updates_that_are_newer_than_their_layer_wait_for_it)
{
  CostOrder order;
  std::string problem;
  EXPECT_FALSE(order.arrange(made("x", {0}, {7}, 2), problem));
  EXPECT_FALSE(order.arrange(made("x", {0, 1}, {8, 8}, 3), problem));
  EXPECT_FALSE(order.arrange(made("x", {3}, {9}, 0), problem)) << "any layer is newer";
  EXPECT_FALSE(order.arrange(made("y", {0}, {1}, 1), problem));
  EXPECT_EQ(problem, "");
  EXPECT_EQ(order.waitingValues(), 4u);
  CostLayer other = madeLayer("b", {1, 2, 3, 4}, 1);
  EXPECT_EQ(order.arrange(other), "");
  EXPECT_EQ(order.waitingValues(), 4u) << "another mesh";
  CostLayer layer = madeLayer("a", {1, 2, 3, 4}, 1);
  EXPECT_EQ(order.arrange(layer), "");
  EXPECT_EQ(layer.costs, (Values{8, 8, 3, 4}));
  EXPECT_EQ(order.waitingValues(), 1u);
  const auto large = made("never comes", std::vector<std::uint32_t>(1000), Values(1000), 1);
  for (std::size_t i = 0; i < 3 * CostOrder::MAX_WAITING_VALUES / 1000; ++i) {
    order.arrange(large, problem);
  }
  EXPECT_EQ(order.waitingValues(), CostOrder::MAX_WAITING_VALUES);
  order.forgetUpdates();
  EXPECT_EQ(order.waitingValues(), 0u);
}

TEST(CostOrder, small_updates_that_wait_are_bounded_too)
{
  CostOrder order;
  std::string problem;
  for (std::size_t i = 0; i < CostOrder::MAX_WAITING_UPDATES + 5; ++i) {
    order.arrange(made("never comes", {0}, {1}, 1), problem);
  }
  EXPECT_EQ(order.waitingValues(), CostOrder::MAX_WAITING_UPDATES);
  const auto empty = made("never comes", {}, {}, 1);
  for (std::size_t i = 0; i <= CostOrder::MAX_WAITING_UPDATES; ++i) {
    order.arrange(empty, problem);
  }
  EXPECT_EQ(order.waitingValues(), CostOrder::MAX_WAITING_UPDATES);
  EXPECT_EQ(empty.use_count(), 1) << "it changes nothing";
}

TEST(CostOrder, updates_that_do_not_fit_their_layer_are_left_out_as_a_whole)
{
  const std::string reason =
      "an update of layer 'x': entry 1 refers to vertex 4, but there are 4; publish the update "
      "for this geometry";
  CostOrder order;
  std::string problem;
  EXPECT_FALSE(order.arrange(made("x", {1, 4}, {0, 0}, 2), problem));
  EXPECT_EQ(problem, "") << "its layer is not known";
  CostLayer layer = madeLayer("a", {1, 2, 3, 4}, 1);
  EXPECT_EQ(order.arrange(layer), reason);
  EXPECT_EQ(layer.costs, (Values{1, 2, 3, 4}));
  EXPECT_FALSE(order.arrange(made("x", {1, 4}, {0, 0}, 2), problem));
  EXPECT_EQ(problem, reason);
  EXPECT_FALSE(order.arrange(made("x", {1}, {0, 0}, 2), problem));
  EXPECT_EQ(problem, "an update of layer 'x' has 2 costs for 1 vertices");
  const auto good = made("x", {1}, {0}, 2);
  EXPECT_EQ(order.arrange(good, problem), good);
  EXPECT_EQ(problem, "");
  EXPECT_EQ(order.stale(), 0u);
}

// The GUI thread forgets a topic while messages of others go on.
TEST(CostOrder, begins_anew_where_the_layers_are_forgotten)
{
  AttributeQueue queue;
  EXPECT_TRUE(queue.receive(layer(1, {1, 1})));
  EXPECT_TRUE(queue.receive(update(5, {0}, {9})));
  queue.forget(MeshMember::COSTS);
  EXPECT_TRUE(queue.receive(layer(3, {2, 2})));
  auto content = queue.take();
  ASSERT_EQ(content.costs.size(), 1u);
  EXPECT_EQ(content.costs[0]->costs, (Values{2, 2})) << "the update was for the layer before";
  EXPECT_TRUE(content.changed_costs.empty());
}

namespace {

/// How many updates are stale of one for each of three layers, whose newest updates are known for
/// so many vertices, where each layer has had a newer one.
std::size_t staleOf(std::size_t max_remembered)
{
  CostOrder order(max_remembered);
  const auto update = [&](const std::string& type, std::uint64_t stamp) {
    auto made = std::make_shared<CostUpdate>();
    made->uuid = "mesh";
    made->type = type;
    made->stamp = stamp;
    made->vertices = {1};
    made->costs = {1.0f};
    std::string problem;
    const CostUpdateConstPtr counts = order.arrange(CostUpdateConstPtr(made), problem);
    EXPECT_EQ(problem, "");
    return counts;
  };
  for (const std::string type : {"a", "b", "c"}) {
    CostLayer layer;
    layer.uuid = "mesh";
    layer.type = type;
    layer.stamp = 10;
    layer.costs.resize(VERTICES);
    EXPECT_EQ(order.arrange(layer), "");
    EXPECT_TRUE(update(type, 30));
  }
  for (const std::string type : {"a", "b", "c"}) {
    EXPECT_FALSE(update(type, 5));  // older than the layer itself, however little is known
  }
  const std::size_t old = order.stale();
  for (const std::string type : {"c", "b", "a"}) {
    update(type, 20);
  }
  return order.stale() - old;
}

}  // namespace

TEST(CostOrder, knows_the_newest_updates_of_so_many_vertices)
{
  EXPECT_EQ(staleOf(3 * VERTICES), 3u);
  EXPECT_EQ(staleOf(2 * VERTICES), 2u);
  EXPECT_EQ(staleOf(1), 1u);  // that of the last layer, in any case
}
