#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "rviz_mesh_plugin/color_scale.h"

using rviz_mesh_plugin::ColorScale;
using rviz_mesh_plugin::CostLimits;
using rviz_mesh_plugin::Rgba8;

namespace rviz_mesh_plugin {
// Prints colors of failing assertions; found by argument-dependent look-up.
void PrintTo(const Rgba8& color, std::ostream* stream)
{
  *stream << "(" << int(color.red) << ", " << int(color.green) << ", " << int(color.blue) << ", "
          << int(color.alpha) << ")";
}
}  // namespace rviz_mesh_plugin

namespace {

constexpr float INF = std::numeric_limits<float>::infinity();
constexpr float NAN_COST = std::numeric_limits<float>::quiet_NaN();
const Rgba8 RED{255, 0, 0, 255};
const Rgba8 YELLOW{255, 255, 0, 255};
const Rgba8 GREEN{0, 255, 0, 255};
const Rgba8 CYAN{0, 255, 255, 255};
const Rgba8 BLUE{0, 0, 255, 255};
const Rgba8 MAGENTA{255, 0, 255, 255};

}  // namespace

TEST(ColorScale, rainbow_runs_from_magenta_over_five_stops_to_red)
{
  const std::vector<Rgba8> stops{MAGENTA, BLUE, CYAN, GREEN, YELLOW, RED};
  for (std::size_t i = 0; i < stops.size(); ++i) {
    EXPECT_EQ(scaleColor(ColorScale::RAINBOW, 0.2f * i), stops[i]) << "stop " << i;
  }
}

TEST(ColorScale, red_green_runs_from_green_over_yellow_to_red)
{
  EXPECT_EQ(scaleColor(ColorScale::RED_GREEN, 0.0f), GREEN);
  EXPECT_EQ(scaleColor(ColorScale::RED_GREEN, 0.5f), YELLOW);
  EXPECT_EQ(scaleColor(ColorScale::RED_GREEN, 1.0f), RED);
}

TEST(ColorScale, both_are_linear_between_their_stops)
{
  // Every channel of a linear piece is halfway between those of its ends, to within rounding.
  for (const auto& scale :
       {std::make_pair(ColorScale::RAINBOW, 5), std::make_pair(ColorScale::RED_GREEN, 2)}) {
    for (int piece = 0; piece < scale.second; ++piece) {
      const float lower = static_cast<float>(piece) / scale.second;
      const float upper = static_cast<float>(piece + 1) / scale.second;
      const Rgba8 a = scaleColor(scale.first, lower);
      const Rgba8 b = scaleColor(scale.first, upper);
      for (int step = 1; step < 16; ++step) {
        const float part = step / 16.0f;
        const Rgba8 c = scaleColor(scale.first, lower + part * (upper - lower));
        EXPECT_NEAR(c.red, a.red + part * (b.red - a.red), 1.0);
        EXPECT_NEAR(c.green, a.green + part * (b.green - a.green), 1.0);
        EXPECT_NEAR(c.blue, a.blue + part * (b.blue - a.blue), 1.0);
        EXPECT_EQ(c.alpha, 255);
      }
    }
  }
}

TEST(ColorScale, positions_outside_are_clamped)
{
  EXPECT_EQ(scaleColor(ColorScale::RAINBOW, -3.0f), MAGENTA);
  EXPECT_EQ(scaleColor(ColorScale::RAINBOW, 7.0f), RED);
}

TEST(CostSummary, limits_are_those_of_the_finite_costs)
{
  const auto summary =
      rviz_mesh_plugin::summarizeCosts({NAN_COST, 2.0f, INF, -1.0f, 0.5f, INF, NAN_COST, NAN_COST});
  EXPECT_EQ(summary.limits.lower, -1.0f);
  EXPECT_EQ(summary.limits.upper, 2.0f);
  EXPECT_EQ(summary.finite, 3u);
  EXPECT_EQ(summary.lethal, 2u);
  EXPECT_EQ(summary.unknown, 3u);
}

TEST(CostSummary, limits_of_negative_costs_are_negative)
{
  const auto summary = rviz_mesh_plugin::summarizeCosts({-5.0f, -2.0f, -3.0f});
  EXPECT_EQ(summary.limits.lower, -5.0f);
  EXPECT_EQ(summary.limits.upper, -2.0f);
}

TEST(CostSummary, without_finite_costs_the_limits_are_zero)
{
  for (const auto& costs : {std::vector<float>{}, std::vector<float>{INF, NAN_COST}}) {
    const auto summary = rviz_mesh_plugin::summarizeCosts(costs);
    EXPECT_EQ(summary.finite, 0u);
    EXPECT_EQ(summary.limits.lower, 0.0f);
    EXPECT_EQ(summary.limits.upper, 0.0f);
  }
}

TEST(CostColor, is_clamped_to_the_limits)
{
  const CostLimits limits{10.0f, 20.0f};
  EXPECT_EQ(costColor(ColorScale::RED_GREEN, limits, 5.0f), GREEN);
  EXPECT_EQ(costColor(ColorScale::RED_GREEN, limits, 15.0f), YELLOW);
  EXPECT_EQ(costColor(ColorScale::RED_GREEN, limits, 25.0f), RED);
}

TEST(CostColor, lethal_is_the_end_of_the_scale_and_unknown_is_grey)
{
  for (const CostLimits& limits :
       {CostLimits{0.0f, 1.0f}, CostLimits{0.0f, 0.0f}, CostLimits{1.0f, 0.0f}}) {
    EXPECT_EQ(costColor(ColorScale::RAINBOW, limits, INF), RED);
    EXPECT_EQ(costColor(ColorScale::RAINBOW, limits, NAN_COST), (Rgba8{128, 128, 128, 255}));
  }
}

TEST(CostColor, of_a_constant_layer_is_the_first_color)
{
  const std::vector<float> costs{0.7f, 0.7f, INF, NAN_COST};
  const auto summary = rviz_mesh_plugin::summarizeCosts(costs);
  const auto colors = costColors(ColorScale::RAINBOW, summary.limits, costs);
  EXPECT_EQ(colors,
            (std::vector<Rgba8>{MAGENTA, MAGENTA, RED, rviz_mesh_plugin::UNKNOWN_COST_COLOR}));
}

TEST(CostColor, limits_the_other_way_round_reverse_the_scale)
{
  const CostLimits limits{1.0f, 0.0f};
  EXPECT_EQ(costColor(ColorScale::RED_GREEN, limits, 1.0f), GREEN);
  EXPECT_EQ(costColor(ColorScale::RED_GREEN, limits, 0.0f), RED);
}

TEST(CostColor, survives_limits_whose_span_no_float_can_hold)
{
  constexpr float GREATEST = std::numeric_limits<float>::max();
  const CostLimits limits{-GREATEST, GREATEST};
  EXPECT_EQ(costColor(ColorScale::RED_GREEN, limits, 0.0f), YELLOW);
  EXPECT_EQ(costColor(ColorScale::RED_GREEN, limits, GREATEST), RED);
}
