// Fields of shortest ways: the same bits as a plain Dijkstra with a heap, in whatever steps they
// were made, whatever has changed since, and wherever a search was broken off.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <queue>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "distance/dijkstra/dijkstra.h"
#include "distance/dijkstra/dijkstra_labels.h"

using mesh_map::DijkstraField;
using mesh_map::DijkstraGraph;
using mesh_map::DijkstraReach;
using mesh_map::VertexCosts;

namespace {

constexpr float INF = std::numeric_limits<float>::infinity();

/// Vertices and edges whose weights and costs change, and how to search them plainly.
struct World
{
  std::vector<std::uint32_t> edges;  // two vertices each
  std::vector<float> weights, costs;
  std::vector<std::uint32_t> offsets, neighbors, neighbor_edges;
  float cost_limit = 1.0f;

  World(std::size_t vertex_count, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs)
      : weights(pairs.size(), 1.0f), costs(vertex_count, 0.0f)
  {
    std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> rows(vertex_count);
    for (const auto& pair : pairs) {
      const auto edge = static_cast<std::uint32_t>(edges.size() / 2);
      rows[pair.first].push_back({pair.second, edge});
      rows[pair.second].push_back({pair.first, edge});
      edges.insert(edges.end(), {pair.first, pair.second});
    }
    offsets.push_back(0);
    for (const auto& row : rows) {
      for (const auto& neighbor : row) {
        neighbors.push_back(neighbor.first);
        neighbor_edges.push_back(neighbor.second);
      }
      offsets.push_back(static_cast<std::uint32_t>(neighbors.size()));
    }
  }

  std::shared_ptr<DijkstraGraph> graph() const
  {
    return std::make_shared<DijkstraGraph>(mesh_map::RowsView{offsets, neighbors}, neighbor_edges,
                                           weights);
  }

  VertexCosts vertexCosts() const { return {costs, cost_limit}; }

  std::vector<float> distances(const std::vector<std::uint32_t>& sources,
                               const std::vector<float>& starts) const
  {
    using Entry = std::pair<float, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
    std::vector<float> result(costs.size(), INF);
    const auto offer = [&](std::uint32_t v, float distance) {
      if (distance < result[v] && costs[v] <= cost_limit && costs[v] < INF) {
        result[v] = distance;
        queue.push({distance, v});
      }
    };
    for (std::size_t i = 0; i < sources.size(); ++i) {
      offer(sources[i], starts[i]);
    }
    while (!queue.empty()) {
      const Entry entry = queue.top();
      queue.pop();
      for (std::uint32_t i = offsets[entry.second]; i < offsets[entry.second + 1]; ++i) {
        offer(neighbors[i], entry.first + weights[neighbor_edges[i]]);
      }
    }
    return result;
  }

  float weight(std::uint32_t a, std::uint32_t b) const
  {
    for (std::uint32_t i = offsets[a]; i < offsets[a + 1]; ++i) {
      if (neighbors[i] == b) {
        return weights[neighbor_edges[i]];
      }
    }
    return INF;
  }
};

World randomWorld(std::mt19937& random, std::uint32_t vertex_count, unsigned edge_count)
{
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (unsigned i = 0; i < edge_count; ++i) {
    const std::uint32_t a = random() % vertex_count, b = random() % vertex_count;
    if (a != b) {
      pairs.insert({std::min(a, b), std::max(a, b)});
    }
  }
  return World(vertex_count, {pairs.begin(), pairs.end()});
}

World grid(std::uint32_t size, unsigned seed)
{
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t v = 0; v < size * size; ++v) {
    if (v % size + 1 < size) {
      pairs.push_back({v, v + 1});
    }
    if (v + size < size * size) {
      pairs.push_back({v, v + size});
    }
  }
  World world(size * size, pairs);
  std::mt19937 random(seed);
  for (float& weight : world.weights) {
    weight = 0.5f + 0.001f * static_cast<float>(random() % 1000);
  }
  return world;
}

struct Seeds
{
  std::vector<std::uint32_t> vertices;
  std::vector<float> starts;
};

std::unique_ptr<DijkstraField> newField(const World& world, const Seeds& seeds)
{
  return std::make_unique<DijkstraField>(world.graph(),
                                         mesh_map::makeDijkstraPool(world.costs.size()),
                                         seeds.vertices, seeds.starts, world.vertexCosts());
}

/// All that a field says is what a plain search finds, as far as it says something.
void expectRight(const DijkstraField& field, const World& world, const Seeds& seeds)
{
  const std::vector<float> expected = world.distances(seeds.vertices, seeds.starts);
  const auto count = static_cast<std::uint32_t>(expected.size());
  const std::vector<float> potential = field.potential();
  const std::vector<std::uint32_t> predecessors = field.predecessors();
  for (std::uint32_t v = 0; v < count; ++v) {
    const bool is_known = expected[v] <= field.limit() && expected[v] < INF;
    ASSERT_EQ(potential[v], is_known ? expected[v] : INF) << "vertex " << v;
    ASSERT_EQ(field.reaches(v), is_known);
    const std::uint32_t before = predecessors[v];
    const std::vector<std::uint32_t> way = field.pathFrom(v);
    ASSERT_EQ(way.empty(), !is_known);
    if (before != v) {
      ASSERT_TRUE(is_known);
      ASSERT_EQ(potential[before] + world.weight(before, v), potential[v]);
      ASSERT_EQ(way[1], before);
    } else if (is_known) {
      bool is_source = false;
      for (std::size_t i = 0; i < seeds.vertices.size(); ++i) {
        is_source = is_source || (seeds.vertices[i] == v && seeds.starts[i] == potential[v]);
      }
      ASSERT_TRUE(is_source);
      ASSERT_EQ(way, std::vector<std::uint32_t>{v});
    }
  }
}

/// New costs at some vertices, and new weights at some of their edges. Returns these vertices.
std::vector<std::uint32_t> change(World& world, std::mt19937& random, unsigned most,
                                  const std::vector<float>& weights)
{
  const float costs[] = {0.0f, 0.0f, 0.5f, 1.5f, INF, NAN};
  std::vector<std::uint32_t> changed;
  for (unsigned i = 1 + random() % most; i > 0; --i) {
    const auto v = static_cast<std::uint32_t>(random() % world.costs.size());
    changed.push_back(v);
    world.costs[v] = costs[random() % 6];
    for (std::uint32_t k = world.offsets[v]; k < world.offsets[v + 1]; ++k) {
      if (random() % 2 == 0) {
        world.weights[world.neighbor_edges[k]] = weights[random() % weights.size()];
      }
    }
  }
  return changed;
}

DijkstraReach randomReach(std::mt19937& random, std::vector<std::uint32_t>& targets,
                          std::size_t vertex_count, float unit)
{
  DijkstraReach reach;
  targets.clear();
  for (unsigned i = random() % 3; i > 0; --i) {
    targets.push_back(static_cast<std::uint32_t>(random() % vertex_count));
  }
  reach.targets = targets;
  reach.offset = unit * static_cast<float>(random() % 3);
  if (random() % 2 == 0) {
    reach.max_distance = unit * static_cast<float>(random() % 10);
  }
  return reach;
}

/// A field knows as much as it was asked for, and no more.
void expectLimit(float limit, float before, const DijkstraReach& reach,
                 const std::vector<float>& distances)
{
  float needed = reach.targets.empty() ? INF : 0.0f;
  for (const std::uint32_t target : reach.targets) {
    needed = std::max(needed, distances[target]);
  }
  needed = std::max(before, std::min(needed + reach.offset, reach.max_distance));
  const bool is_all = std::none_of(distances.begin(), distances.end(),
                                   [&](float d) { return d > needed && d < INF; });
  ASSERT_TRUE(limit == needed || (is_all && limit == INF)) << limit << " not " << needed;
}

/// Any sequence of steps and changes.
void tryWorld(unsigned seed, const std::vector<float>& weights)
{
  std::mt19937 random(seed);
  const std::uint32_t count = 20 + random() % 60;
  World world = randomWorld(random, count, count * (1 + random() % 4));
  for (float& weight : world.weights) {
    weight = weights[random() % weights.size()];
  }
  const float unit = *std::max_element(weights.begin(), weights.end() - 1);
  Seeds seeds;
  for (unsigned i = 1 + random() % 3; i > 0; --i) {
    seeds.vertices.push_back(random() % count);
    seeds.starts.push_back(unit * static_cast<float>(random() % 3));
  }
  auto field = newField(world, seeds);
  expectRight(*field, world, seeds);
  std::vector<std::uint32_t> targets;
  auto graph = world.graph();
  std::vector<std::unique_ptr<World>> worlds;  // costs have to outlive the field
  for (unsigned step = 0; step < 12; ++step) {
    if (random() % 2 == 0) {
      const DijkstraReach reach = randomReach(random, targets, count, unit);
      const float before = field->limit();
      ASSERT_TRUE(field->extend(reach));
      ASSERT_NO_FATAL_FAILURE(expectLimit(field->limit(), before, reach,
                                          world.distances(seeds.vertices, seeds.starts)));
    } else {
      worlds.push_back(std::make_unique<World>(world));
      const std::vector<float> before = world.weights;
      const std::vector<std::uint32_t> changed = change(world, random, 5, weights);
      graph = graph->withWeights(world.edges, before, world.weights);
      worlds.push_back(std::make_unique<World>(world));
      std::size_t work = 0;
      const float limit = field->limit();
      ASSERT_TRUE(field->update(graph, worlds.back()->vertexCosts(), changed, work));
      ASSERT_GE(field->limit(), limit);
    }
    ASSERT_NO_FATAL_FAILURE(expectRight(*field, world, seeds)) << "step " << step;
  }
  ASSERT_TRUE(field->extend({}));
  ASSERT_EQ(field->limit(), INF);
  ASSERT_NO_FATAL_FAILURE(expectRight(*field, world, seeds));
}

TEST(Dijkstra, AnySequenceOfStepsAndChangesGivesTheBitsOfAPlainSearch)
{
  for (unsigned seed = 0; seed < 150; ++seed) {
    ASSERT_NO_FATAL_FAILURE(tryWorld(seed, {0.0f, 0.1f, 0.2f, 0.3f, 7.0f, INF})) << seed;
    ASSERT_NO_FATAL_FAILURE(tryWorld(seed, {0.1f, 0.7f, 1.3f, 1.7f, 2.9f, INF})) << seed;
    ASSERT_NO_FATAL_FAILURE(tryWorld(seed, {1e-30f, 1e-9f, 1.0f, 3e7f, 1e30f, INF})) << seed;
  }
}

TEST(Dijkstra, RoundingMayLeadOverManyBuckets)
{
  World world = grid(30, 2);
  for (std::size_t e = 0; e < world.weights.size(); ++e) {
    const bool is_bridge = world.edges[2 * e] % 30 == 14 && world.edges[2 * e + 1] % 30 == 15;
    world.weights[e] = is_bridge ? 1.2f : 0.1f;
  }
  const Seeds seeds{{0, 450}, {2e7f, 2e7f}};  // where floats are 2 apart, 16 widths of a bucket
  auto field = newField(world, seeds);
  ASSERT_TRUE(field->extend({}));
  expectRight(*field, world, seeds);
}

/// Goes on in steps that are all broken off, and looks at each. Returns how many these were.
unsigned goOn(DijkstraField& field, const World& world, const Seeds& seeds)
{
  const std::atomic<bool> cancel(true);
  unsigned steps = 0;
  for (float before = field.limit(); !field.extend({}, &cancel); before = field.limit()) {
    ++steps;
    EXPECT_GT(field.limit(), before);
    expectRight(field, world, seeds);
  }
  EXPECT_EQ(field.limit(), INF);
  return steps;
}

TEST(Dijkstra, AFieldThatWasBrokenOffIsRightAsFarAsItGoesAndGoesOn)
{
  const World world = grid(90, 3);
  const Seeds seeds{{0, 7000}, {0.0f, 1.0f}};
  auto field = newField(world, seeds);
  EXPECT_GE(goOn(*field, world, seeds), 7u);
}

TEST(Dijkstra, AFieldMayBeBrokenOffByAnotherThread)
{
  const World world = grid(120, 3);
  const Seeds seeds{{0, 7000}, {0.0f, 1.0f}};
  for (unsigned attempt = 0; attempt < 20; ++attempt) {
    auto field = newField(world, seeds);
    std::atomic<bool> cancel(false);
    std::thread other([&] {
      for (volatile unsigned i = 0; i < 2000 * attempt; i = i + 1) {
      }
      cancel = true;
    });
    const bool is_done = field->extend({}, &cancel);
    other.join();
    EXPECT_TRUE(!is_done || field->limit() == INF);
    ASSERT_NO_FATAL_FAILURE(expectRight(*field, world, seeds));
  }
}

TEST(Dijkstra, AnUpdateThatWasBrokenOffHasTheNewCostsAndGoesOn)
{
  const World world = grid(90, 4);
  const Seeds seeds{{4050}, {0.0f}};
  World changed = world;
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 30 * 90 + 40; v < 60 * 90; v += 90) {  // a wall, and a piece next to it
    vertices.push_back(v);
    changed.costs[v] = v % 20 == 0 ? NAN : INF;
  }
  const std::atomic<bool> cancel(true);
  for (const bool is_closing : {true, false}) {
    const World& first = is_closing ? world : changed;
    const World& second = is_closing ? changed : world;
    auto field = newField(first, seeds);
    ASSERT_TRUE(field->extend({}));
    std::size_t work = 0;
    ASSERT_FALSE(field->update(second.graph(), second.vertexCosts(), vertices, work, &cancel));
    EXPECT_GT(work, 20u);
    expectRight(*field, second, seeds);
    goOn(*field, second, seeds);
    expectRight(*field, second, seeds);
  }
}

TEST(Dijkstra, AnUpdateLooksOnlyAtWhatDependsOnTheChange)
{
  World world = grid(100, 5);
  const Seeds seeds{{0}, {0.0f}};
  auto field = newField(world, seeds);
  ASSERT_TRUE(field->extend({}));
  std::size_t work = 0;
  ASSERT_TRUE(field->update(world.graph(), world.vertexCosts(),
                            std::vector<std::uint32_t>{0, 5, 9999}, work));
  EXPECT_EQ(work, 0u);
  const World before = world;
  world.costs[9898] = INF;  // in the corner farthest from the source
  const std::vector<std::uint32_t> corner = {9898}, source = {0};
  ASSERT_TRUE(field->update(world.graph(), world.vertexCosts(), corner, work));
  EXPECT_GE(work, 1u);
  EXPECT_LT(work, 50u);
  expectRight(*field, world, seeds);

  const World open = world;
  world.costs[0] = INF;
  ASSERT_TRUE(field->update(world.graph(), world.vertexCosts(), source, work));
  expectRight(*field, world, seeds);
  EXPECT_TRUE(field->pathFrom(1).empty());
  ASSERT_TRUE(field->update(open.graph(), open.vertexCosts(), source, work));
  expectRight(*field, open, seeds);
  EXPECT_EQ(field->pathFrom(1).size(), 2u);
}

World chain(std::uint32_t vertex_count)
{
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t v = 0; v + 1 < vertex_count; ++v) {
    pairs.push_back({v, v + 1});
  }
  return World(vertex_count, pairs);
}

TEST(Dijkstra, ManyUpdatesLeaveNoMoreToSearchThanOne)
{
  World world = chain(3000);
  auto field = newField(world, {{0}, {0.0f}});
  DijkstraReach reach;
  reach.max_distance = 20.5f;
  ASSERT_TRUE(field->extend(reach));
  const std::vector<std::uint32_t> ends = {20, 21};  // of an edge that leads beyond what is known
  std::size_t work = 0;
  for (unsigned i = 0; i < 2000; ++i) {
    world.weights[20] = i % 2 == 0 ? 2.0f : 1.0f;
    ASSERT_TRUE(field->update(world.graph(), world.vertexCosts(), ends, work));
  }
  const std::atomic<bool> cancel(true);
  EXPECT_FALSE(field->extend({}, &cancel));
  EXPECT_GT(field->limit(), 1000.0f);  // all steps were taken along the chain
  expectRight(*field, world, {{0}, {0.0f}});
}

TEST(Dijkstra, AFieldThatWasBrokenOffAmongEdgesWithoutLengthKnowsWhatItDoesNotKnow)
{
  World world = chain(5000);
  std::fill(world.weights.begin() + 1, world.weights.end(), 0.0f);
  const Seeds seeds{{0}, {0.0f}};
  auto field = newField(world, seeds);
  const std::atomic<bool> cancel(true);
  ASSERT_FALSE(field->extend({}, &cancel));
  ASSERT_NO_FATAL_FAILURE(expectRight(*field, world, seeds));
  DijkstraReach reach;
  reach.max_distance = 1.0f;
  ASSERT_TRUE(field->extend(reach));
  EXPECT_TRUE(field->reaches(4999));
  expectRight(*field, world, seeds);
}

TEST(Dijkstra, WhatIsKnownCostsNothing)
{
  const World world = grid(40, 6);
  auto field = newField(world, {{820}, {0.0f}});
  const std::vector<std::uint32_t> target = {900};
  DijkstraReach reach;
  reach.targets = target;
  reach.offset = 2.0f;
  ASSERT_TRUE(field->extend(reach));
  const float limit = field->limit();
  const std::atomic<bool> cancel(true);  // nothing that could be canceled
  ASSERT_TRUE(field->extend(reach, &cancel));
  EXPECT_EQ(field->limit(), limit);
  reach.offset = 2.5f;
  EXPECT_FALSE(field->extend(reach, &cancel));
}

TEST(Dijkstra, MemoryIsUsedAgainAsNewAndNeverTwiceAtATime)
{
  const World world = grid(40, 7);
  const auto pool = mesh_map::makeDijkstraPool(1600);
  const std::vector<std::uint32_t> vertex = {820};
  const std::vector<float> start = {0.0f};
  const auto solve = [&](float max_distance) {
    auto field =
        std::make_unique<DijkstraField>(world.graph(), pool, vertex, start, world.vertexCosts());
    DijkstraReach reach;
    reach.max_distance = max_distance;
    EXPECT_TRUE(field->extend(reach));
    return field;
  };
  for (const float max_distance : {3.0f, INF}) {  // few labels were touched, and all of them
    auto kept = solve(INF);
    solve(max_distance).reset();
    const auto labels = pool->take();
    EXPECT_EQ(labels->touchedCount(), 0u);
    for (std::uint32_t v = 0; v < 1600; ++v) {
      EXPECT_EQ((*labels)[v].distance, INF);
      EXPECT_EQ((*labels)[v].from, mesh_map::NO_INDEX);
    }
    auto other = solve(max_distance);
    expectRight(*kept, world, {vertex, start});
    expectRight(*other, world, {vertex, start});
  }
  auto first = pool->take();
  auto second = pool->take();
  EXPECT_NE(first.get(), second.get());
  const mesh_map::DijkstraLabels* const address = second.get();
  pool->give(std::move(second));
  EXPECT_EQ(pool->take().get(), address);
}

TEST(Dijkstra, OtherWeightsAreThoseOfANewGraph)
{
  std::mt19937 random(8);
  World world = grid(20, 8);
  auto graph = world.graph();
  for (unsigned round = 0; round < 10; ++round) {
    const std::vector<float> before = world.weights;
    const auto changed = change(world, random, 20, {0.0f, 0.4f, 5.0f, INF});
    graph = graph->withWeights(world.edges, before, world.weights);
    const auto expected = world.graph();
    for (std::uint32_t v = 0; v < 400; ++v) {
      for (std::size_t i = 0; i < expected->arcs(v).size(); ++i) {
        ASSERT_EQ(graph->arcs(v)[i].to, expected->arcs(v)[i].to);
        ASSERT_EQ(graph->arcs(v)[i].weight, expected->arcs(v)[i].weight);
      }
    }
    std::set<std::uint32_t> ends;
    for (std::size_t e = 0; e < before.size(); ++e) {
      if (before[e] != world.weights[e]) {
        ends.insert({world.edges[2 * e], world.edges[2 * e + 1]});
      }
    }
    const auto found = mesh_map::verticesAtChanges(world.edges, before, world.weights);
    EXPECT_EQ(std::set<std::uint32_t>(found.begin(), found.end()), ends);
  }
  std::vector<float> closed = world.weights;
  closed[0] = closed[700] = INF;
  EXPECT_TRUE(mesh_map::areLengthsOrClosed(closed, world.weights));
  closed[400] = 17.0f;
  EXPECT_FALSE(mesh_map::areLengthsOrClosed(closed, world.weights));
  closed[400] = -1.0f;
  EXPECT_THROW(graph->withWeights(world.edges, world.weights, closed), std::invalid_argument);
}

TEST(Dijkstra, OtherWeightsAreMeasuredAgainWhereTheyMatter)
{
  World world = grid(20, 8);
  const std::vector<float> given = world.weights;
  const auto graph = world.graph();
  world.weights[5] = 1e7f;
  const auto jump = graph->withWeights(world.edges, given, world.weights);
  EXPECT_EQ(jump->typical(), graph->typical());  // one among many
  const auto back = jump->withWeights(world.edges, world.weights, given);
  EXPECT_EQ(back->typical(), graph->typical());

  // step by step, each of them of a few
  auto longer = graph;
  world.weights = given;
  for (std::size_t e = 0; e < given.size(); ++e) {
    const std::vector<float> before = world.weights;
    world.weights[e] *= 1000.0f;
    longer = longer->withWeights(world.edges, before, world.weights);
  }
  EXPECT_GT(longer->typical(), 0.8 * world.graph()->typical());
}

TEST(Dijkstra, WrongArgumentsAreRefused)
{
  const World world = grid(3, 9);
  EXPECT_THROW(newField(world, {{9}, {0.0f}}), std::invalid_argument);
  EXPECT_THROW(newField(world, {{0}, {-1.0f}}), std::invalid_argument);
  EXPECT_THROW(newField(world, {{0}, {NAN}}), std::invalid_argument);
  EXPECT_THROW(newField(world, {{0, 1}, {0.0f}}), std::invalid_argument);
  auto field = newField(world, {{0}, {0.0f}});
  DijkstraReach reach;
  reach.max_distance = NAN;
  EXPECT_THROW(field->extend(reach), std::invalid_argument);
  const World other = grid(4, 9);
  std::size_t work = 0;
  EXPECT_THROW(field->update(other.graph(), world.vertexCosts(), {}, work), std::invalid_argument);
  EXPECT_THROW(field->update(world.graph(), other.vertexCosts(), {}, work), std::invalid_argument);
  const std::vector<std::uint32_t> wrong = {9};
  EXPECT_THROW(field->update(world.graph(), world.vertexCosts(), wrong, work),
               std::invalid_argument);
  const std::vector<std::uint32_t> sources = {0};
  const std::vector<float> starts = {0.0f};
  EXPECT_THROW(DijkstraField(world.graph(), mesh_map::makeDijkstraPool(8), sources, starts, {}),
               std::invalid_argument);
}

}  // namespace
