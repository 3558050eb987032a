#include "coloring/cost_coloring.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "legend/legend_picture.h"
#include "support/color_printing.h"

using rviz_mesh_plugin::ColorScale;
using rviz_mesh_plugin::CostColoring;
using rviz_mesh_plugin::CostLimits;
using rviz_mesh_plugin::CostSummary;
using rviz_mesh_plugin::Rgba8;
using rviz_mesh_plugin::summarizeCosts;

namespace {

constexpr float INF = std::numeric_limits<float>::infinity();
constexpr float NAN_COST = std::numeric_limits<float>::quiet_NaN();
constexpr float GREATEST = std::numeric_limits<float>::max();
constexpr float LEAST = std::numeric_limits<float>::denorm_min();
const Rgba8 RED{255, 0, 0, 255};
const Rgba8 YELLOW{255, 255, 0, 255};
const Rgba8 GREEN{0, 255, 0, 255};
const Rgba8 WHITE{255, 255, 255, 255};
const Rgba8 BLACK{0, 0, 0, 255};
const Rgba8 BLUE{0, 0, 255, 255};
const Rgba8 LETHAL = rviz_mesh_plugin::LETHAL_COST_COLOR;
const Rgba8 UNKNOWN = rviz_mesh_plugin::UNKNOWN_COST_COLOR;

CostColoring redGreen(const std::function<void(CostColoring&)>& change = {})
{
  CostColoring coloring;
  coloring.scale = ColorScale::RED_GREEN;
  if (change) {
    change(coloring);
  }
  return coloring;
}

/// By the definition.
float positionOf(const CostColoring& coloring, const CostLimits& limits, float cost)
{
  const bool logarithmic = isLogarithmic(coloring, limits);
  const auto value = [&](double of) { return logarithmic ? std::log(std::max(of, 0.0)) : of; };
  const double lower = value(limits.lower);
  return static_cast<float>(
      std::clamp((value(cost) - lower) / (value(limits.upper) - lower), 0.0, 1.0));
}

std::vector<Rgba8> colorsOf(const std::vector<float>& costs, const CostColoring& coloring)
{
  auto layer = std::make_shared<rviz_mesh_plugin::CostLayer>();
  layer->costs = costs;
  layer->summary = summarizeCosts(costs);
  std::vector<std::uint32_t> sources(costs.size());
  std::iota(sources.begin(), sources.end(), 0u);
  std::vector<Rgba8> colors(costs.size());
  colorSource(layer, coloring)(sources.data(), sources.size(), colors.data());
  return colors;
}

std::vector<float> randomCosts(std::size_t count)
{
  std::mt19937 random(7);
  std::normal_distribution<float> costs(0.0f, 3.0f);
  std::vector<float> values(count);
  std::generate(values.begin(), values.end(), [&] { return costs(random); });
  return values;
}

}  // namespace

TEST(CostSummary, counts_and_limits)
{
  const CostSummary summary =
      summarizeCosts({NAN_COST, 2.0f, INF, -1.0f, 0.5f, INF, NAN_COST, NAN_COST, 0.0f});
  EXPECT_EQ(summary.limits.lower, -1.0f);
  EXPECT_EQ(summary.limits.upper, 2.0f);
  EXPECT_EQ(summary.finite, 4u);
  EXPECT_EQ(summary.lethal, 2u);
  EXPECT_EQ(summary.unknown, 3u);
  EXPECT_EQ(summary.positive, 2u);
  EXPECT_EQ(summary.least_positive, 0.5f);
  const CostSummary negative = summarizeCosts({-5.0f, -2.0f, -3.0f});
  EXPECT_EQ(negative.limits.lower, -5.0f);
  EXPECT_EQ(negative.limits.upper, -2.0f);
  EXPECT_EQ(negative.least_positive, 0.0f);
}

TEST(CostSummary, without_finite_costs_limits_and_percentiles_are_zero)
{
  for (const auto& costs : {std::vector<float>{}, std::vector<float>{INF, NAN_COST}}) {
    const CostSummary summary = summarizeCosts(costs);
    EXPECT_EQ(summary.finite, 0u);
    EXPECT_EQ(summary.limits.lower, 0.0f);
    EXPECT_EQ(summary.limits.upper, 0.0f);
    EXPECT_EQ(summary.percentile(50.0), 0.0f);
  }
}

TEST(CostSummary, ranks_are_those_of_a_sort)
{
  for (const std::size_t count :
       {std::size_t{1}, std::size_t{2}, std::size_t{1000}, rviz_mesh_plugin::EXACT_PERCENTILES}) {
    std::vector<float> costs = randomCosts(count);
    costs[0] = -0.0f;
    costs[count - 1] = count > 1 ? -GREATEST : costs[0];
    const CostSummary summary = summarizeCosts(costs);
    std::sort(costs.begin(), costs.end());
    EXPECT_EQ(*summary.ranked, costs) << count;
  }
}

TEST(CostSummary, percentiles_of_few_costs_are_exact)
{
  const CostSummary summary = summarizeCosts({40.0f, 10.0f, INF, 20.0f, NAN_COST, 30.0f, 50.0f});
  EXPECT_EQ(summary.percentile(0.0), 10.0f);
  EXPECT_EQ(summary.percentile(25.0), 20.0f);
  EXPECT_FLOAT_EQ(summary.percentile(30.0), 22.0f);  // between ranks, as numpy has it
  EXPECT_EQ(summary.percentile(100.0), 50.0f);
  EXPECT_EQ(summary.percentile(-5.0), 10.0f);
  EXPECT_EQ(summary.percentile(500.0), 50.0f);
}

TEST(CostSummary, percentiles_of_many_costs_are_within_a_ten_thousandth_of_the_ranks)
{
  std::vector<float> costs = randomCosts(777777);
  const CostSummary summary = summarizeCosts(costs);
  std::sort(costs.begin(), costs.end());
  EXPECT_LT(summary.ranked->size(), 20000u);
  const double last = static_cast<double>(costs.size() - 1);
  for (double percent = 0.0; percent <= 100.0; percent += 0.37) {
    const double least = std::max(percent / 100.0 - 1e-4, 0.0);
    const double most = std::min(percent / 100.0 + 1e-4, 1.0);
    const float value = summary.percentile(percent);
    EXPECT_GE(value, costs[static_cast<std::size_t>(std::floor(least * last))]) << percent;
    EXPECT_LE(value, costs[static_cast<std::size_t>(std::ceil(most * last))]) << percent;
  }
  EXPECT_EQ(summary.percentile(0.0), costs.front());
  EXPECT_EQ(summary.percentile(100.0), costs.back());
}

struct LimitsCase
{
  const char* what;
  std::vector<float> costs;
  std::function<void(CostColoring&)> change;
  CostLimits expected;
  const char* note;
};

TEST(CostColoring, limits)
{
  const auto custom = [](float lower, float upper, bool logarithmic = false) {
    return [=](CostColoring& coloring) {
      coloring.custom_limits = true;
      coloring.limits = {lower, upper};
      coloring.logarithmic = logarithmic;
    };
  };
  const auto clipped = [](float percent) {
    return [=](CostColoring& coloring) { coloring.clipped = percent; };
  };
  const auto logarithmic = [](CostColoring& coloring) { coloring.logarithmic = true; };
  std::vector<float> hundred(101);
  std::iota(hundred.begin(), hundred.end(), 0.0f);
  std::vector<float> outlier(1000, 0.0f);
  outlier[17] = 9.0f;
  const std::vector<LimitsCase> cases{
      {"automatic", {3, INF, 1, NAN_COST}, {}, {1, 3}, ""},
      {"custom", {3, 1}, custom(-2, 7), {-2, 7}, ""},
      {"backwards", {3, 1}, custom(7, -2), {7, -2}, ""},
      {"clipped", hundred, clipped(5), {5, 95}, ""},
      {"clipped to nothing", outlier, clipped(5), {0, 9}, ""},
      {"clipped by half", hundred, clipped(50), {0, 100}, ""},
      {"custom limits are not clipped",
       hundred,
       [&](CostColoring& coloring) {
         custom(1, 2)(coloring);
         clipped(5)(coloring);
       },
       {1, 2},
       ""},
      {"logarithmic", {1, 1000}, logarithmic, {1, 1000}, ""},
      {"logarithmic with 0",
       {0, 0.5f, 8},
       logarithmic,
       {0.5f, 8},
       "1 cost that is not above 0 has no logarithm: drawn as the lowest"},
      {"logarithmic, all negative",
       {-3, -1},
       logarithmic,
       {-3, -1},
       "the scale is linear, since no cost is above 0"},
      {"logarithmic, custom from 0",
       {0.25f, 8},
       custom(0, 4, true),
       {0.25f, 4},
       "the scale begins at 0.25, since a limit is not above 0"},
      {"logarithmic, custom below all costs",
       {5, 8},
       custom(-1, 4, true),
       {0.004f, 4},
       "the scale begins at 0.004, since a limit is not above 0"},
      {"logarithmic, custom backwards",
       {0.25f, 8},
       custom(4, 0, true),
       {4, 0.25f},
       "the scale begins at 0.25, since a limit is not above 0"},
      {"logarithmic, custom negative",
       {5, 8},
       custom(-4, -1, true),
       {-4, -1},
       "the scale is linear, since no limit is above 0"},
      {"logarithmic without costs", {INF}, logarithmic, {0, 0}, ""},
  };
  for (const LimitsCase& test : cases) {
    const CostColoring coloring = redGreen(test.change);
    const CostSummary summary = summarizeCosts(test.costs);
    const CostLimits limits = limitsOf(coloring, summary);
    EXPECT_EQ(limits.lower, test.expected.lower) << test.what;
    EXPECT_EQ(limits.upper, test.expected.upper) << test.what;
    EXPECT_EQ(coloringNote(coloring, summary), test.note) << test.what;
  }
}

struct ColorCase
{
  const char* what;
  CostColoring coloring;
  CostLimits limits;
  float cost;
  Rgba8 expected;
};

TEST(CostColoring, color_of_a_cost)
{
  const CostColoring plain = redGreen();
  const CostColoring inverted = redGreen([](CostColoring& c) { c.inverted = true; });
  const CostColoring logarithmic = redGreen([](CostColoring& c) { c.logarithmic = true; });
  const CostColoring marked = redGreen([](CostColoring& c) {
    c.mark_outside = true;
    c.below = BLUE;
    c.above = BLACK;
    c.lethal = WHITE;
    c.unknown = YELLOW;
  });
  const auto with_threshold = [](bool mark) {
    return redGreen([mark](CostColoring& c) {
      c.mark_lethal = mark;
      c.least_lethal = 15.0f;
      c.lethal = WHITE;
      c.mark_outside = true;
      c.above = BLACK;
    });
  };
  const std::vector<ColorCase> cases{
      {"least lethal", with_threshold(true), {10, 20}, 15, WHITE},
      {"lethal by its value, outside", with_threshold(true), {10, 20}, 25, WHITE},
      {"just not lethal", with_threshold(true), {10, 20}, std::nextafter(15.0f, 0.0f), YELLOW},
      {"lethal by its value, not marked", with_threshold(false), {10, 20}, 15, YELLOW},
      {"infinite, not marked", with_threshold(false), {10, 20}, INF, WHITE},
      {"unknown with a threshold", with_threshold(true), {10, 20}, NAN_COST, UNKNOWN},
      {"below", plain, {10, 20}, 5, GREEN},
      {"middle", plain, {10, 20}, 15, YELLOW},
      {"above", plain, {10, 20}, 25, RED},
      {"lethal", plain, {10, 20}, INF, LETHAL},
      {"unknown", plain, {10, 20}, NAN_COST, UNKNOWN},
      {"below all", plain, {10, 20}, -INF, GREEN},
      {"constant", plain, {7, 7}, 7, GREEN},
      {"above a constant", plain, {7, 7}, 8, RED},
      {"backwards, lower", plain, {1, 0}, 1, GREEN},
      {"backwards, upper", plain, {1, 0}, 0, RED},
      {"backwards, unknown", plain, {1, 0}, NAN_COST, UNKNOWN},
      {"span beyond float", plain, {-GREATEST, GREATEST}, 0, YELLOW},
      {"span beyond float, upper", plain, {-GREATEST, GREATEST}, GREATEST, RED},
      {"least span, lower", plain, {0, LEAST}, 0, GREEN},
      {"least span, upper", plain, {0, LEAST}, LEAST, RED},
      {"inverted, lower", inverted, {0, 1}, 0, RED},
      {"inverted, upper", inverted, {0, 1}, 1, GREEN},
      {"inverted, lethal", inverted, {0, 1}, INF, LETHAL},
      {"inverted constant", inverted, {7, 7}, 7, RED},
      {"logarithmic middle", logarithmic, {0.01f, 100}, 1, YELLOW},
      {"logarithmic backwards", logarithmic, {100, 0.01f}, 0.01f, RED},
      {"logarithmic, 0", logarithmic, {0.01f, 100}, 0, GREEN},
      {"logarithmic backwards, 0", logarithmic, {100, 0.01f}, 0, RED},
      {"logarithmic, negative", logarithmic, {0.01f, 100}, -3, GREEN},
      {"logarithmic, not possible", logarithmic, {-5, -1}, -3, YELLOW},
      {"logarithmic, widest", logarithmic, {LEAST, GREATEST}, GREATEST, RED},
      {"marked below", marked, {10, 20}, 5, BLUE},
      {"marked above", marked, {10, 20}, 25, BLACK},
      {"marked, at the limit", marked, {10, 20}, 20, RED},
      {"marked below, backwards", marked, {20, 10}, 5, BLUE},
      {"marked, inside backwards", marked, {20, 10}, 15, YELLOW},
      {"marked lethal", marked, {10, 20}, INF, WHITE},
      {"marked unknown", marked, {10, 20}, NAN_COST, YELLOW},
      {"marked, -inf", marked, {10, 20}, -INF, BLUE},
  };
  for (const ColorCase& test : cases) {
    CostColoring custom = test.coloring;
    custom.custom_limits = true;
    custom.limits = test.limits;
    const auto colors = colorsOf({test.cost, 1e-30f}, custom);
    EXPECT_EQ(colors[0], test.expected) << test.what;
  }
}

TEST(CostColoring, colors_differ_from_those_of_the_scale_by_one_step_at_most)
{
  std::vector<float> costs = randomCosts(20000);
  costs[5] = INF;
  costs[6] = NAN_COST;
  for (const auto& named : rviz_mesh_plugin::colorScales()) {
    for (const bool logarithmic : {false, true}) {
      CostColoring coloring;
      coloring.scale = named.scale;
      coloring.logarithmic = logarithmic;
      coloring.inverted = logarithmic;
      const CostLimits limits = limitsOf(coloring, summarizeCosts(costs));
      const std::vector<Rgba8> colors = colorsOf(costs, coloring);
      for (std::size_t i = 0; i < costs.size(); ++i) {
        const float position = positionOf(coloring, limits, costs[i]);
        const Rgba8 expected =
            std::isnan(costs[i]) ? coloring.unknown
            : std::isinf(costs[i])
                ? coloring.lethal
                : scaleColor(coloring.scale, coloring.inverted ? 1.0f - position : position);
        ASSERT_LE(std::abs(colors[i].red - expected.red), 1) << named.name << " " << costs[i];
        ASSERT_LE(std::abs(colors[i].green - expected.green), 1) << named.name << " " << costs[i];
        ASSERT_LE(std::abs(colors[i].blue - expected.blue), 1) << named.name << " " << costs[i];
      }
    }
  }
}

TEST(CostColoring, sources_choose_the_costs)
{
  auto layer = std::make_shared<rviz_mesh_plugin::CostLayer>();
  layer->costs = {0.0f, 1.0f, NAN_COST};
  layer->summary = summarizeCosts(layer->costs);
  const auto source = colorSource(layer, redGreen());
  layer.reset();  // the source owns what it reads
  const std::vector<std::uint32_t> sources{1, 1, 2, 0};
  std::vector<Rgba8> colors(4);
  source(sources.data(), sources.size(), colors.data());
  EXPECT_EQ(colors, (std::vector<Rgba8>{RED, RED, UNKNOWN, GREEN}));
}

struct TicksCase
{
  CostLimits limits;
  bool logarithmic;
  std::size_t most;
  std::string labels;
};

TEST(ScaleTicks, are_round_numbers)
{
  const std::vector<TicksCase> cases{
      {{0, 1}, false, 6, "0 0.2 0.4 0.6 0.8 1.0"},
      {{1, 0}, false, 6, "0 0.2 0.4 0.6 0.8 1.0"},
      {{0, 1}, false, 5, "0 0.5 1.0"},
      {{0, 1}, false, 2, "0 1"},
      {{-3.2f, 7.9f}, false, 8, "-2 0 2 4 6"},
      {{-3.2f, 7.9f}, false, 12, "-3 -2 -1 0 1 2 3 4 5 6 7"},
      {{0, 0.035f}, false, 8, "0 0.005 0.010 0.015 0.020 0.025 0.030 0.035"},
      {{1000, 1000.5f}, false, 6, "1000.0 1000.1 1000.2 1000.3 1000.4 1000.5"},
      {{0, 3e6f}, false, 4, "0 1e+06 2e+06 3e+06"},
      {{0, 3e-6f}, false, 4, "0 1e-06 2e-06 3e-06"},
      {{-GREATEST, GREATEST}, false, 5, "-2e+38 0 2e+38"},
      {{7.25f, 7.25f}, false, 6, "7.25"},
      {{0, 0}, true, 6, "0"},
      {{0.01f, 100}, true, 6, "0.01 0.1 1 10 100"},
      {{1, 100}, true, 9, "1 2 5 10 20 50 100"},
      {{2, 8}, true, 9, "2 3 4 5 6 7 8"},
      {{1e-30f, 1e30f}, true, 6, "1e-22 1e-11 1 1e+11 1e+22"},
      {{-1, 1}, true, 5, "-1.0 -0.5 0 0.5 1.0"},
  };
  for (const TicksCase& test : cases) {
    const CostColoring coloring =
        redGreen([&](CostColoring& c) { c.logarithmic = test.logarithmic; });
    const auto ticks = scaleTicks(coloring, test.limits, test.most);
    std::string labels;
    double previous = -1.0;
    for (const auto& tick : ticks) {
      labels += (labels.empty() ? "" : " ") + tick.label;
      EXPECT_GT(tick.position, previous);
      EXPECT_LE(tick.position, 1.0);
      previous = tick.position;
      if (test.limits.lower < test.limits.upper) {
        EXPECT_NEAR(tick.position,
                    positionOf(coloring, test.limits, static_cast<float>(tick.value)), 1e-4);
      }
    }
    EXPECT_EQ(labels, test.labels);
  }
}

TEST(ScaleTicks, there_are_always_some_and_never_too_many)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<float> exponents(-38.0f, 38.0f);
  std::uniform_real_distribution<float> spans(-6.0f, 30.0f);
  for (int i = 0; i < 2000; ++i) {
    const float lower = std::pow(10.0f, exponents(random));
    const float upper = std::min(lower * (1.0f + std::pow(10.0f, spans(random))), GREATEST);
    const CostColoring coloring = redGreen([&](CostColoring& c) { c.logarithmic = i % 2 == 1; });
    const std::size_t most = 2 + static_cast<std::size_t>(i % 9);
    const auto ticks = scaleTicks(coloring, {lower, upper}, most);
    EXPECT_LE(ticks.size(), most) << lower << " " << upper;
    if (most >= 5) {
      EXPECT_GE(ticks.size(), 1u) << lower << " " << upper;
    }
  }
}
