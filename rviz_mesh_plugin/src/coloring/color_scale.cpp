#include "coloring/color_scale.h"

#include <algorithm>
#include <array>

#include "coloring/color_maps.h"

namespace rviz_mesh_plugin {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

std::vector<Rgb> parseColorMap(const ColorMap& map)
{
  const auto digit = [](char character) {
    return character <= '9' ? character - '0' : character - 'a' + 10;
  };
  std::vector<Rgb> stops(COLOR_MAP_SIZE);
  const char* text = map.colors;
  for (Rgb& stop : stops) {
    for (std::uint8_t& channel : stop) {
      channel = static_cast<std::uint8_t>(16 * digit(text[0]) + digit(text[1]));
      text += 2;
    }
  }
  return stops;
}

/// Of the scales in the order of their numbers; the colors run linearly between equally spaced
/// stops.
std::vector<std::vector<Rgb>> makeStops()
{
  std::vector<std::vector<Rgb>> stops{
      {{255, 0, 255}, {0, 0, 255}, {0, 255, 255}, {0, 255, 0}, {255, 255, 0}, {255, 0, 0}},
      {{0, 255, 0}, {255, 255, 0}, {255, 0, 0}}};
  for (const ColorMap& map : COLOR_MAP_TABLES) {
    stops.push_back(parseColorMap(map));
  }
  stops.push_back({{0, 0, 0}, {255, 255, 255}});
  return stops;
}

const std::vector<Rgb>& stopsOf(ColorScale scale)
{
  static const std::vector<std::vector<Rgb>> stops = makeStops();
  const auto number = static_cast<std::size_t>(scale);
  return stops[number < stops.size() ? number : 0];
}

}  // namespace

const std::vector<NamedColorScale>& colorScales()
{
  static const std::vector<NamedColorScale> scales{
      {ColorScale::RAINBOW, "Rainbow"}, {ColorScale::RED_GREEN, "Red Green"},
      {ColorScale::VIRIDIS, "Viridis"}, {ColorScale::PLASMA, "Plasma"},
      {ColorScale::INFERNO, "Inferno"}, {ColorScale::MAGMA, "Magma"},
      {ColorScale::CIVIDIS, "Cividis"}, {ColorScale::TURBO, "Turbo"},
      {ColorScale::JET, "Jet"},         {ColorScale::COOLWARM, "Coolwarm"},
      {ColorScale::GREY, "Grey"}};
  return scales;
}

Rgba8 scaleColor(ColorScale scale, float position)
{
  const std::vector<Rgb>& stops = stopsOf(scale);
  position = std::min(std::max(position, 0.0f), 1.0f);
  const float scaled = position * static_cast<float>(stops.size() - 1);
  const std::size_t first = std::min(static_cast<std::size_t>(scaled), stops.size() - 2);
  const float part = scaled - static_cast<float>(first);
  const auto channel = [&](std::size_t i) {
    const float from = stops[first][i];
    return static_cast<std::uint8_t>(from + part * (stops[first + 1][i] - from) + 0.5f);
  };
  return {channel(0), channel(1), channel(2), 255};
}

ColorTable::ColorTable(ColorScale scale, bool inverted) : colors_(STEPS + 1)
{
  for (std::size_t i = 0; i <= STEPS; ++i) {
    const float position = static_cast<float>(i) / static_cast<float>(STEPS);
    colors_[inverted ? STEPS - i : i] = scaleColor(scale, position);
  }
}

}  // namespace rviz_mesh_plugin
