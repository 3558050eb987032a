// Fronts from a point: exact on planes, near great circles, on any mesh; stopped, gone on with,
// canceled, and mended after changes.

#include <mesh_map/distance/fast_marching/fast_marching.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <thread>

#include "core/support/front_checks.h"

namespace mesh_map {
namespace {

using Slowness = std::vector<float>;

struct Fronts
{
  FrontSample sample;
  std::shared_ptr<FastMarchingPool> pool;

  explicit Fronts(TestMesh mesh)
      : sample(std::move(mesh)), pool(std::make_shared<FastMarchingPool>(sample.front))
  {
  }

  std::unique_ptr<FastMarchingField> start(std::uint32_t source,
                                           const Slowness& slowness = {}) const
  {
    return std::make_unique<FastMarchingField>(pool, std::vector<FastMarchingSeed>{{source, 0.0}},
                                               slowness);
  }

  std::vector<double> solve(std::uint32_t source, const Slowness& slowness = {}) const
  {
    const auto field = start(source, slowness);
    EXPECT_TRUE(field->extend(slowness, {}));
    EXPECT_EQ(field->limit(), FAR);
    return {field->labels().begin(), field->labels().end()};
  }
};

/// The largest relative difference of labels up to a limit.
double difference(ArrayView<double> labels, ArrayView<double> expected, double limit = FAR)
{
  double worst = 0.0;
  for (std::size_t v = 0; v < labels.size(); ++v) {
    if (labels[v] != expected[v] && (labels[v] <= limit || expected[v] <= limit * (1 - 1e-5))) {
      worst = std::max(worst, std::abs(labels[v] - expected[v]) / expected[v]);
    }
  }
  return worst;
}

Slowness randomSlowness(std::size_t size, double share_closed, unsigned seed)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(1.0f, 4.0f);
  const auto closed = randomMask(size, share_closed, seed + 1);
  Slowness slowness(size);
  for (std::size_t v = 0; v < size; ++v) {
    slowness[v] = closed[v] == 0 ? value(random) : v % 2 == 0 ? FAR : std::nanf("");
  }
  return slowness;
}

/// What each label should be by edges alone, at most.
double edgeExcess(const FrontSample& sample, const std::vector<double>& labels,
                  const Slowness& slowness)
{
  double worst = -1.0;
  for (std::size_t e = 0; e < sample.topology.edgeCount(); ++e) {
    const std::uint32_t a = sample.topology.edges[2 * e], b = sample.topology.edges[2 * e + 1];
    const double s = slowness.empty() ? 1.0 : 0.5 * (double{slowness[a]} + slowness[b]);
    if (s < FAR && (labels[a] < FAR || labels[b] < FAR)) {
      const double most = s * between(sample.mesh, a, b) + 2e-6 * std::min(labels[a], labels[b]);
      worst = std::max(worst, std::abs(labels[a] - labels[b]) - most);
    }
  }
  return worst;
}

TEST(WaveFront, IsExactOnPlanes)
{
  // Regular, jittered, and squeezed to slivers; from a corner, the border and within.
  for (const double jitter : {0.0, 0.1, 0.24}) {
    for (const float squeezed : {1.0f, 1e-3f}) {
      TestMesh mesh = plane(60, jitter);
      for (std::size_t v = 0; v < 61 * 61; ++v) {
        for (std::size_t axis = 0; axis < 2; ++axis) {
          const std::size_t place = axis == 0 ? v / 61 : v % 61;
          float& x = mesh.positions[3 * v + axis];
          x = place % 60 == 0 ? 0.1f * static_cast<float>(place) : x;  // straight borders
          x *= axis == 0 ? 1.0f : squeezed;
        }
      }
      const Fronts fronts(mesh);
      for (const std::uint32_t source : {0u, 30u, 20u * 61u + 33u}) {
        const std::vector<double> labels = fronts.solve(source);
        for (std::uint32_t v = 0; v < labels.size(); ++v) {
          const double expected = between(mesh, source, v);
          if (expected > (squeezed < 1.0f ? 0.1 : 1.0)) {
            ASSERT_NEAR(labels[v] / expected, 1.0, 1e-4)
                << "vertex " << v << " from " << source << ", " << jitter << ", " << squeezed;
          }
        }
      }
    }
  }
}

TEST(WaveFront, EndsOnAnyMeshAndDiffersByNoMoreThanEdges)
{
  for (const TestMesh& mesh : frontMeshes()) {
    const Fronts fronts(mesh);
    const std::size_t size = fronts.sample.size();
    const double scale = 1e-6 * fronts.sample.longestEdge();
    for (const Slowness& slowness :
         {Slowness{}, Slowness(size, 0.0f), randomSlowness(size, 0.1, 7), Slowness(size, 1e6f)}) {
      std::uint32_t source = 0;
      while (!slowness.empty() && !(slowness[source] < FAR)) {
        ++source;
      }
      const std::vector<double> labels = fronts.solve(source, slowness);
      const double most = scale * (slowness.empty() ? 1.0 : 4.0 + slowness[0]);
      EXPECT_LE(edgeExcess(fronts.sample, labels, slowness), most) << mesh.name;
      for (std::size_t v = 0; v < size; ++v) {
        ASSERT_TRUE(labels[v] >= 0.0) << mesh.name;
        if (!slowness.empty() && !(slowness[v] < FAR)) {
          ASSERT_EQ(labels[v], FAR) << mesh.name;
        }
      }
    }
  }
}

TEST(WaveFront, IsNotPassedByClosedLinesOneVertexThick)
{
  const Fronts fronts(plane(40, 0.2));
  Slowness slowness(fronts.sample.size(), 1.0f);
  for (std::size_t j = 0; j <= 40; ++j) {
    slowness[20 * 41 + j] = j % 2 == 0 ? FAR : std::nanf("");
  }
  std::vector<double> labels = fronts.solve(18 * 41 + 30, slowness);
  for (std::size_t v = 0; v < labels.size(); ++v) {
    EXPECT_EQ(labels[v] < FAR, v < 20 * 41) << v;
  }
  for (std::size_t j = 0; j < 5; ++j) {
    slowness[20 * 41 + j] = 1.0f;
  }
  // Round the end of the line, and round all faces at its closed vertices.
  const std::uint32_t source = 18 * 41 + 30, behind = 22 * 41 + 30, end = 20 * 41 + 4;
  const auto& mesh = fronts.sample.mesh;
  const double way = between(mesh, source, end) + between(mesh, end, behind);
  const double found = fronts.solve(source, slowness)[behind];
  EXPECT_GT(found, way);
  EXPECT_LT(found, way + 0.15);
  EXPECT_EQ(fronts.solve(20 * 41 + 10, slowness)[0], FAR);  // a closed source starts nothing
}

TEST(WaveFront, SlownessScalesAndContrastsDoNotShorten)
{
  const Fronts fronts(plane(40, 0.2));
  const std::vector<double> plain = fronts.solve(820);
  for (const float factor : {3.0f, 1e6f, 1e-6f}) {
    const auto slow = fronts.solve(820, Slowness(fronts.sample.size(), factor));
    for (std::size_t v = 0; v < slow.size(); ++v) {
      EXPECT_NEAR(slow[v], factor * plain[v], 1e-5 * factor * plain[v]);
    }
  }
  // Islands a thousand times as slow: every way is at least as long as on the plane.
  Slowness slowness(fronts.sample.size(), 1.0f);
  const auto islands = randomMask(slowness.size(), 0.3, 5);
  std::transform(islands.begin(), islands.end(), slowness.begin(),
                 [](std::uint8_t island) { return island != 0 ? 1000.0f : 1.0f; });
  const std::vector<double> labels = fronts.solve(820, slowness);
  for (std::uint32_t v = 0; v < labels.size(); ++v) {
    EXPECT_GE(labels[v], (1 - 1e-5) * between(fronts.sample.mesh, 820, v)) << v;
  }
}

TEST(WaveFront, StopsGoesOnAndIsCancelledWithoutAnyDifference)
{
  const Fronts fronts(terrain(60));
  for (const Slowness& slowness : {Slowness{}, randomSlowness(61 * 61, 0.05, 3)}) {
    const std::uint32_t source = 1801 + (slowness.empty() || slowness[1801] < FAR ? 0 : 1);
    const std::vector<double> all = fronts.solve(source, slowness);
    const auto field = fronts.start(source, slowness);
    double last = -1.0;
    for (const std::uint32_t target : {1870u, 1200u, 3000u, 10u}) {
      const std::vector<std::uint32_t> targets{target};
      FastMarchingStop stop;
      stop.targets = targets;
      stop.offset = 0.2;
      ASSERT_TRUE(field->extend(slowness, stop));
      if (all[target] < FAR) {
        EXPECT_EQ(field->labels()[target], all[target]);
        EXPECT_GE(field->limit(), all[target] + stop.offset);
      }
      EXPECT_GE(field->limit(), last);
      EXPECT_LE(difference(field->labels(), all, field->limit()), 1e-6);
      last = field->limit();
    }
    const std::atomic<bool> cancel{true};
    FastMarchingStop stop;
    stop.cancel = &cancel;
    EXPECT_EQ(field->extend(slowness, stop), last == FAR);
    EXPECT_EQ(field->limit(), last);
    ASSERT_TRUE(field->extend(slowness, {}));
    EXPECT_EQ(std::vector<double>(field->labels().begin(), field->labels().end()), all);
  }
}

TEST(WaveFront, WhatIsFarIsNotReached)
{
  const Fronts fronts(plane(30, 0.2));
  const auto field = fronts.start(480);
  FastMarchingStop stop;
  stop.max_distance = 0.8;
  ASSERT_TRUE(field->extend({}, stop));
  EXPECT_EQ(field->limit(), 0.8);
  const std::vector<float> potential = field->potential();
  const std::vector<double> all = fronts.solve(480);
  for (std::size_t v = 0; v < all.size(); ++v) {
    EXPECT_EQ(potential[v], all[v] <= 0.8 ? static_cast<float>(all[v]) : FAR);
  }
  stop.max_distance = 100.0;
  ASSERT_TRUE(field->extend({}, stop));
  EXPECT_EQ(field->limit(), FAR);  // nothing is left
}

TEST(WaveFront, UpdatesAreAsANewField)
{
  for (const TestMesh& mesh : {terrain(50), plane(40, 0.3), cube(12)}) {
    const Fronts fronts(mesh);
    for (unsigned seed = 0; seed < 6; ++seed) {
      std::mt19937 random(seed);
      Slowness slowness = randomSlowness(fronts.sample.size(), 0.1 * (seed % 3), seed);
      const auto source = static_cast<std::uint32_t>(random() % slowness.size());
      slowness[source] = 1.0f;
      const auto field = fronts.start(source, slowness);
      FastMarchingStop stop;
      stop.max_distance = seed % 2 == 0 ? FAR : 3.0;
      ASSERT_TRUE(field->extend(slowness, stop));
      for (unsigned round = 0; round < 6; ++round) {
        std::vector<std::uint32_t> changed;
        for (unsigned i = 0; i < 1 + round; ++i) {
          const auto v = static_cast<std::uint32_t>(random() % slowness.size());
          if (v != source) {
            slowness[v] = random() % 3 == 0 ? FAR : 1.0f + static_cast<float>(random() % 4);
            changed.push_back(v);
          }
        }
        const std::atomic<bool> cancel{round % 3 == 2};
        auto update = field->update({{source, 0.0}}, slowness, changed, &cancel);
        if (update.canceled) {
          ASSERT_TRUE(field->extend(slowness, stop));
        }
        const std::vector<double> expected = fronts.solve(source, slowness);
        ASSERT_LE(difference(field->labels(), expected, field->limit()), 1e-5)
            << mesh.name << " seed " << seed << " round " << round;
        ASSERT_GE(field->limit(), seed % 2 == 0 ? FAR : 2.0);
      }
    }
  }
}

TEST(WaveFront, ALittleChangeIsLittleWork)
{
  const Fronts fronts(terrain(60));
  Slowness slowness(fronts.sample.size(), 1.0f);
  const auto field = fronts.start(0, slowness);
  ASSERT_TRUE(field->extend(slowness, {}));
  const std::vector<std::uint32_t> changed{61 * 61 - 65};
  slowness[changed[0]] = FAR;
  const auto closed = field->update({{0, 0.0}}, slowness, changed, nullptr);
  EXPECT_GT(closed.count, 0u);
  EXPECT_LT(closed.count, 60u);
  EXPECT_EQ(field->update({{0, 0.0}}, slowness, changed, nullptr).count, 0u);
  // Another seed is a change, too.
  EXPECT_GT(field->update({{0, 0.0}, {1860, 0.0}}, slowness, {}, nullptr).count, 100u);
  EXPECT_EQ(field->labels()[1860], 0.0);
}

/// Few or many: those that have other labels, and hardly more, each once.
TEST(WaveFront, CountsEachLabelThatAChangeHasChangedOnce)
{
  const Fronts fronts(plane(120, 0.24));
  for (const unsigned width : {1u, 60u}) {
    Slowness slowness(fronts.sample.size(), 1.0f);
    const auto field = fronts.start(60, slowness);
    ASSERT_TRUE(field->extend(slowness, {}));
    std::vector<std::uint32_t> changed;
    for (std::uint32_t j = 0; j < width; ++j) {
      changed.push_back((width > 1 ? 100 : 120) * 121 + 30 + j);  // the last row has nothing behind
    }
    for (const float value : {1.5f, 1.0f}) {
      const std::vector<double> before(field->labels().begin(), field->labels().end());
      for (const std::uint32_t v : changed) {
        slowness[v] = value;
      }
      const auto update = field->update({{60, 0.0}}, slowness, changed, nullptr);
      std::size_t differing = 0;
      for (std::uint32_t v = 0; v < slowness.size(); ++v) {
        differing += field->labels()[v] != before[v] ? 1 : 0;
      }
      EXPECT_LT(update.count, slowness.size()) << "a new field";
      EXPECT_GE(update.count, differing) << width;
      EXPECT_LT(static_cast<double>(update.count), 1.2 * static_cast<double>(differing)) << width;
      EXPECT_EQ(differing < 14, width == 1) << differing;
    }
  }
}

/// Those around which a change may be seen: two rings, and what is across the edges of the first.
std::set<std::uint32_t> around(const TestMesh& mesh, const std::vector<std::uint32_t>& changed)
{
  std::set<std::uint32_t> first(changed.begin(), changed.end()), second;
  const auto grow = [&mesh](const std::set<std::uint32_t>& of, unsigned least) {
    std::set<std::uint32_t> all(of);
    for (std::size_t f = 0; f < mesh.faces.size(); f += 3) {
      const auto begin = mesh.faces.begin() + static_cast<std::ptrdiff_t>(f);
      if (std::count_if(begin, begin + 3, [&](auto v) { return of.count(v) > 0; }) >= least) {
        all.insert(begin, begin + 3);
      }
    }
    return all;
  };
  return grow(grow(first, 1), 2);
}

TEST(WaveFront, EachLabelAroundChangesIsLookedAtOnce)
{
  const Fronts fronts(terrain(60));
  const Slowness slowness(fronts.sample.size(), 1.0f);
  const auto field = fronts.start(0, slowness);
  ASSERT_TRUE(field->extend(slowness, {}));
  std::vector<std::uint32_t> changed;
  for (std::uint32_t v = 30 * 61 + 20; v < 31 * 61; ++v) {
    changed.push_back(v);
  }
  const auto update = field->update({{0, 0.0}}, slowness, changed, nullptr);
  EXPECT_EQ(update.count, 0u);  // the slowness is as before
  EXPECT_LE(update.looks, around(fronts.sample.mesh, changed).size());
  EXPECT_GE(update.looks, changed.size());
}

/// Where everything behind many small changes is to be other, it is not even begun with.
TEST(WaveFront, ScatteredChangesMakeANewField)
{
  const Fronts fronts(terrain(150));
  Slowness slowness(fronts.sample.size(), 1.0f);
  const auto field = fronts.start(0, slowness);
  ASSERT_TRUE(field->extend(slowness, {}));
  std::vector<std::uint32_t> changed;
  for (std::uint32_t v = 77; v < slowness.size(); v += 101) {
    changed.push_back(v);
    slowness[v] = 1.5f;
  }
  const auto update = field->update({{0, 0.0}}, slowness, changed, nullptr);
  EXPECT_EQ(update.looks, 0u);
  EXPECT_EQ(update.count, slowness.size());
  const std::vector<double> expected = fronts.solve(0, slowness);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), field->labels().begin()));
}

/// So it is seen soon that a change next to the goal changes everything.
TEST(WaveFront, AChangeBeforeEverythingIsGivenUpSoon)
{
  const Fronts fronts(terrain(150));
  Slowness slowness(fronts.sample.size(), 1.0f);
  const std::uint32_t goal = 75 * 151 + 75;
  const auto field = fronts.start(goal, slowness);
  ASSERT_TRUE(field->extend(slowness, {}));
  slowness[goal] = 3.0f;
  const auto update =
      field->update({{goal, 0.0}}, slowness, std::vector<std::uint32_t>{goal}, nullptr);
  EXPECT_EQ(update.count, slowness.size());
  EXPECT_GT(update.looks, 0u);
  EXPECT_LT(update.looks, slowness.size() / 8);
  const std::vector<double> expected = fronts.solve(goal, slowness);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), field->labels().begin()));
}

/// Across obtuse corners labels follow from others that are not below them. Where costs rise, these
/// are taken back with what they follow from, not with all that is around them, again and again.
TEST(WaveFront, HigherCostsTakeLabelsBackOnlyWithWhatTheyFollowFrom)
{
  const Fronts fronts(plane(150, 0.3));
  const std::size_t size = fronts.sample.size();
  std::mt19937 random(4);
  std::uniform_real_distribution<float> rough(1.0f, 1.6f);
  Slowness slowness(size);
  std::generate(slowness.begin(), slowness.end(), [&]() { return rough(random); });
  const std::uint32_t source = 75 * 151 + 75;
  const auto field = fronts.start(source, slowness);
  ASSERT_TRUE(field->extend(slowness, {}));
  for (unsigned place = 0; place < 60; ++place) {
    const std::size_t i = 3 + random() % 140, j = 3 + random() % 140;
    if (i > 55 && i < 95 && j > 55 && j < 95) {
      continue;  // much follows from what is near to the source
    }
    std::vector<std::uint32_t> changed;
    for (std::size_t k = 0; k < 64; ++k) {
      changed.push_back(static_cast<std::uint32_t>((i + k / 8) * 151 + j + k % 8));
      slowness[changed.back()] *= 1.5f;
    }
    const auto update = field->update({{source, 0.0}}, slowness, changed, nullptr);
    EXPECT_LT(update.count, size / 4) << place;
    EXPECT_LT(update.looks, 4 * update.count + 8 * changed.size()) << place;
    ASSERT_LE(difference(field->labels(), fronts.solve(source, slowness)), 1e-5) << place;
  }
}

/// From a line of two seeds at the border: a front comes to the last corner from that side of the
/// face behind, though it can not come to the corner between before.
TEST(WaveFront, ComesFromALineOfSeedsAtTheBorder)
{
  const TestMesh mesh{"kite", {0, 0, 0, 1, 0, 0, 0.45f, 0.45f, 0, 0.4f, 1, 0}, {0, 1, 2, 0, 2, 3}};
  const Fronts fronts(mesh);
  FastMarchingField field(fronts.pool, {{0, 0.0}, {1, 0.0}}, {});
  ASSERT_TRUE(field.extend({}, {}));
  EXPECT_NEAR(field.labels()[3], 1.0, 1e-7);
}

/// Where a meter takes no time, all labels are the same, and each follows from the others: only a
/// new field tells what they are.
TEST(WaveFront, LabelsThatFollowFromEachOtherAreNotKept)
{
  const Fronts fronts(plane(12, 0.0));
  Slowness slowness(fronts.sample.size(), 0.0f);
  slowness[0] = 1.0f;
  const auto field = fronts.start(0, slowness);
  ASSERT_TRUE(field->extend(slowness, {}));
  slowness[0] = 2.0f;
  field->update({{0, 0.0}}, slowness, std::vector<std::uint32_t>{0}, nullptr);
  const std::vector<double> expected = fronts.solve(0, slowness);
  EXPECT_GT(*std::max_element(expected.begin(), expected.end()), 0.0);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), field->labels().begin()));
}

TEST(WaveFront, FieldsThatLiveAreNotOverwrittenAndOthersAreUsedAgain)
{
  const Fronts fronts(terrain(40));
  const auto kept = fronts.start(5);
  FastMarchingStop stop;
  stop.max_distance = 2.0;
  ASSERT_TRUE(kept->extend({}, stop));
  const std::vector<double> before(kept->labels().begin(), kept->labels().end());
  const double* memory = nullptr;
  for (std::uint32_t source = 0; source < 40; ++source) {
    const auto field = fronts.start(source);
    ASSERT_TRUE(field->extend({}, source % 2 == 0 ? stop : FastMarchingStop{}));
    EXPECT_NE(field->labels().data(), kept->labels().data());
    EXPECT_TRUE(memory == nullptr || field->labels().data() == memory);
    memory = field->labels().data();
    EXPECT_LE(difference(field->labels(), fronts.solve(source), field->limit()), 1e-6);
  }
  EXPECT_EQ(std::vector<double>(kept->labels().begin(), kept->labels().end()), before);
}

TEST(WaveFront, ThreadsDoNotDisturbEachOther)
{
  const Fronts fronts(terrain(40));
  const std::vector<double> expected[2] = {fronts.solve(3), fronts.solve(900)};
  std::vector<double> found[2];
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < 2; ++i) {
    threads.emplace_back([&, i]() {
      for (unsigned round = 0; round < 5; ++round) {
        found[i] = fronts.solve(i == 0 ? 3 : 900);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(found[0], expected[0]);
  EXPECT_EQ(found[1], expected[1]);
}

TEST(WaveFront, RefusesWhatDoesNotFit)
{
  const Fronts fronts(terrain(5));
  EXPECT_THROW(fronts.start(36), std::invalid_argument);
  EXPECT_THROW(fronts.start(0, {1.0f}), std::invalid_argument);
  EXPECT_THROW(fronts.start(0, Slowness(36, -1.0f)), std::invalid_argument);
  EXPECT_THROW(FastMarchingField(fronts.pool, {{0, -1.0}}, {}), std::invalid_argument);
  EXPECT_THROW(FastMarchingField(fronts.pool, {{0, FAR}}, {}), std::invalid_argument);
  const auto field = fronts.start(0);
  const std::vector<std::uint32_t> wrong{36};
  FastMarchingStop stop;
  stop.targets = wrong;
  EXPECT_THROW(field->extend({}, stop), std::invalid_argument);
  EXPECT_THROW(field->update({{0, 0.0}}, {}, wrong, nullptr), std::invalid_argument);
  EXPECT_THROW(field->update({{36, 0.0}}, {}, {}, nullptr), std::invalid_argument);
  stop.targets = {};
  stop.max_distance = -1.0;
  EXPECT_THROW(field->extend({}, stop), std::invalid_argument);
  stop.max_distance = 1.0;
  stop.offset = -1.0;
  EXPECT_THROW(field->extend({}, stop), std::invalid_argument);
  EXPECT_TRUE(field->extend({}, {}));
}

}  // namespace
}  // namespace mesh_map
