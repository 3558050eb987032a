#include "coloring/color_scale.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "coloring/color_maps.h"
#include "support/color_printing.h"

using rviz_mesh_plugin::COLOR_MAP_SIZE;
using rviz_mesh_plugin::COLOR_MAP_TABLES;
using rviz_mesh_plugin::COLOR_MAPS;
using rviz_mesh_plugin::ColorScale;
using rviz_mesh_plugin::colorScales;
using rviz_mesh_plugin::ColorTable;
using rviz_mesh_plugin::Rgba8;

namespace {

const Rgba8 RED{255, 0, 0, 255};
const Rgba8 YELLOW{255, 255, 0, 255};
const Rgba8 GREEN{0, 255, 0, 255};
const Rgba8 CYAN{0, 255, 255, 255};
const Rgba8 BLUE{0, 0, 255, 255};
const Rgba8 MAGENTA{255, 0, 255, 255};
const Rgba8 BLACK{0, 0, 0, 255};
const Rgba8 WHITE{255, 255, 255, 255};

/// CIELAB of an sRGB color (IEC 61966-2-1, white D65).
std::array<double, 3> labOf(const Rgba8& color)
{
  const auto linear = [](double channel) {
    return channel <= 0.04045 ? channel / 12.92 : std::pow((channel + 0.055) / 1.055, 2.4);
  };
  const double r = linear(color.red / 255.0), g = linear(color.green / 255.0),
               b = linear(color.blue / 255.0);
  const auto bent = [](double share) {
    return share > std::pow(6.0 / 29.0, 3) ? std::cbrt(share) : share * 841.0 / 108.0 + 4.0 / 29.0;
  };
  const double x = bent((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
  const double y = bent(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
  const double z = bent((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

double difference(const Rgba8& a, const Rgba8& b)
{
  const auto p = labOf(a), q = labOf(b);
  return std::sqrt(std::pow(p[0] - q[0], 2) + std::pow(p[1] - q[1], 2) + std::pow(p[2] - q[2], 2));
}

struct Stop
{
  ColorScale scale;
  float position;
  Rgba8 color;
};

bool differsByOneAtMost(const Rgba8& a, const Rgba8& b)
{
  return std::abs(a.red - b.red) <= 1 && std::abs(a.green - b.green) <= 1 &&
         std::abs(a.blue - b.blue) <= 1 && a.alpha == b.alpha;
}

}  // namespace

TEST(ColorScaleTest, lethal_and_unknown_are_in_no_scale)
{
  using rviz_mesh_plugin::LETHAL_COST_COLOR;
  using rviz_mesh_plugin::UNKNOWN_COST_COLOR;
  EXPECT_GT(difference(LETHAL_COST_COLOR, UNKNOWN_COST_COLOR), 60.0);
  for (const auto& named : colorScales()) {
    for (int i = 0; i <= 1000; ++i) {
      const Rgba8 color = rviz_mesh_plugin::scaleColor(named.scale, 0.001f * i);
      ASSERT_GT(difference(color, LETHAL_COST_COLOR), 20.0) << named.name << " at " << i;
      ASSERT_GT(difference(color, UNKNOWN_COST_COLOR), 20.0) << named.name << " at " << i;
    }
  }
}

TEST(ColorScale, numbers_and_names_are_those_of_files)
{
  const std::vector<std::string> names{"Rainbow", "Red Green", "Viridis", "Plasma",
                                       "Inferno", "Magma",     "Cividis", "Turbo",
                                       "Jet",     "Coolwarm",  "Grey"};
  ASSERT_EQ(colorScales().size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(colorScales()[i].scale), i);
    EXPECT_EQ(colorScales()[i].name, names[i]);
  }
}

TEST(ColorScale, stops_have_their_colors)
{
  // The ends and the middle of matplotlib's maps are as published by their authors.
  const std::vector<Stop> stops{
      {ColorScale::RAINBOW, 0.0f, MAGENTA},
      {ColorScale::RAINBOW, 0.2f, BLUE},
      {ColorScale::RAINBOW, 0.4f, CYAN},
      {ColorScale::RAINBOW, 0.6f, GREEN},
      {ColorScale::RAINBOW, 0.8f, YELLOW},
      {ColorScale::RAINBOW, 1.0f, RED},
      {ColorScale::RAINBOW, -3.0f, MAGENTA},
      {ColorScale::RAINBOW, 7.0f, RED},
      {ColorScale::RED_GREEN, 0.0f, GREEN},
      {ColorScale::RED_GREEN, 0.5f, YELLOW},
      {ColorScale::RED_GREEN, 1.0f, RED},
      {ColorScale::VIRIDIS, 0.0f, {68, 1, 84, 255}},
      {ColorScale::VIRIDIS, 128.0f / 255.0f, {32, 144, 140, 255}},
      {ColorScale::VIRIDIS, 1.0f, {253, 231, 36, 255}},
      {ColorScale::PLASMA, 0.0f, {12, 7, 134, 255}},
      {ColorScale::PLASMA, 1.0f, {239, 248, 33, 255}},
      {ColorScale::INFERNO, 0.0f, {0, 0, 3, 255}},
      {ColorScale::INFERNO, 1.0f, {252, 254, 164, 255}},
      {ColorScale::MAGMA, 1.0f, {251, 252, 191, 255}},
      {ColorScale::CIVIDIS, 0.0f, {0, 34, 77, 255}},
      {ColorScale::TURBO, 0.0f, {48, 18, 59, 255}},
      {ColorScale::TURBO, 1.0f, {122, 4, 2, 255}},
      {ColorScale::JET, 0.0f, {0, 0, 127, 255}},
      {ColorScale::JET, 1.0f, {127, 0, 0, 255}},
      {ColorScale::COOLWARM, 0.0f, {58, 76, 192, 255}},
      {ColorScale::COOLWARM, 1.0f, {179, 3, 38, 255}},
      {ColorScale::GREY, 0.0f, BLACK},
      {ColorScale::GREY, 1.0f, WHITE},
      {static_cast<ColorScale>(99), 0.0f, MAGENTA},  // no scale: as the first one
  };
  for (const Stop& stop : stops) {
    EXPECT_TRUE(differsByOneAtMost(scaleColor(stop.scale, stop.position), stop.color))
        << static_cast<int>(stop.scale) << " at " << stop.position << ": "
        << testing::PrintToString(scaleColor(stop.scale, stop.position));
    const bool exact = static_cast<int>(stop.scale) < static_cast<int>(ColorScale::VIRIDIS);
    if (exact) {
      EXPECT_EQ(scaleColor(stop.scale, stop.position), stop.color);
    }
  }
}

TEST(ColorScale, is_linear_between_stops)
{
  // Every channel of a linear piece is between those of its ends, and rounded.
  for (const auto& scale :
       {std::make_pair(ColorScale::RAINBOW, 5), std::make_pair(ColorScale::RED_GREEN, 2),
        std::make_pair(ColorScale::GREY, 1), std::make_pair(ColorScale::VIRIDIS, 255)}) {
    for (int piece = 0; piece < scale.second; ++piece) {
      const float lower = static_cast<float>(piece) / scale.second;
      const float upper = static_cast<float>(piece + 1) / scale.second;
      const Rgba8 a = scaleColor(scale.first, lower);
      const Rgba8 b = scaleColor(scale.first, upper);
      for (int step = 1; step < 16; ++step) {
        const float part = step / 16.0f;
        const Rgba8 c = scaleColor(scale.first, lower + part * (upper - lower));
        EXPECT_NEAR(c.red, a.red + part * (b.red - a.red), 0.51);
        EXPECT_NEAR(c.green, a.green + part * (b.green - a.green), 0.51);
        EXPECT_NEAR(c.blue, a.blue + part * (b.blue - a.blue), 0.51);
        EXPECT_EQ(c.alpha, 255);
      }
    }
  }
}

TEST(ColorTable, differs_from_the_scale_by_one_step_at_most_and_not_at_stops)
{
  for (const auto& named : colorScales()) {
    const ColorTable table(named.scale);
    const ColorTable inverted(named.scale, true);
    for (int i = 0; i <= 100000; ++i) {
      const float position = static_cast<float>(i) / 100000.0f;
      const Rgba8 color = scaleColor(named.scale, position);
      ASSERT_TRUE(differsByOneAtMost(table.at(position), color)) << named.name << " " << position;
      ASSERT_TRUE(differsByOneAtMost(inverted.at(1.0f - position), color)) << named.name;
    }
    for (const int pieces : {5, 2, 255}) {
      for (int i = 0; i <= pieces; ++i) {
        const float position = static_cast<float>(i) / static_cast<float>(pieces);
        ASSERT_EQ(table.at(position), scaleColor(named.scale, position)) << named.name << " " << i;
      }
    }
    EXPECT_EQ(table.at(-1.0f), scaleColor(named.scale, 0.0f));
    EXPECT_EQ(table.at(1e30f), scaleColor(named.scale, 1.0f));
    EXPECT_EQ(inverted.at(0.0f), scaleColor(named.scale, 1.0f));
  }
}

TEST(ColorMaps, tables_are_complete)
{
  ASSERT_EQ(COLOR_MAPS + 3, colorScales().size());
  for (const auto& map : COLOR_MAP_TABLES) {
    EXPECT_EQ(std::string(map.colors).size(), 6 * COLOR_MAP_SIZE) << map.name;
    EXPECT_EQ(std::string(map.colors).find_first_not_of("0123456789abcdef"), std::string::npos);
  }
}

TEST(ColorMaps, are_those_of_matplotlib)
{
  if (std::system("/usr/bin/python3 -c 'import matplotlib; matplotlib.colormaps' 2>/dev/null")) {
    GTEST_SKIP() << "python3-matplotlib 3.5 or newer is not installed";
  }
  FILE* generator =
      popen("/usr/bin/python3 '" GENERATE_COLOR_MAPS "' --stdout | grep -v '^//' 2>&1", "r");
  ASSERT_NE(generator, nullptr);
  std::string generated;
  for (int character; (character = std::fgetc(generator)) != EOF;) {
    generated.push_back(static_cast<char>(character));
  }
  ASSERT_EQ(pclose(generator), 0) << generated;
  std::ifstream file(COLOR_MAPS_SOURCE);
  ASSERT_TRUE(file);
  std::string expected;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("//", 0) != 0) {  // the version of matplotlib is no difference
      expected += line + "\n";
    }
  }
  EXPECT_TRUE(generated == expected) << "run scripts/generate_color_maps.py";
}
