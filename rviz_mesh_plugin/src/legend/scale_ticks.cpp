#include "legend/scale_ticks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace rviz_mesh_plugin {
namespace {

constexpr std::array<double, 3> FACTORS{1.0, 2.0, 5.0};

/// Ticks this much outside the limits, as a share of their distance, are there by rounding.
constexpr double TOLERANCE = 1e-6;

/// From these magnitudes on a label is written with an exponent.
constexpr double LEAST_PLAIN = 1e-3;
constexpr double GREATEST_PLAIN = 1e5;

std::string print(const char* format, int decimals, double value)
{
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, decimals, value);
  std::string label(text.data());
  // RViz may run in a locale with decimal commas; its properties have points all the same.
  std::replace(label.begin(), label.end(), ',', '.');
  return label;
}

/// All labels of one scale alike: with the decimals that @a step needs.
std::string labelOf(double value, double step, double greatest)
{
  if (std::abs(value) < 1e-3 * step) {
    return "0";
  }
  if (greatest >= GREATEST_PLAIN || step < LEAST_PLAIN) {
    const int digits = 1 + static_cast<int>(std::floor(std::log10(greatest)) -
                                            std::floor(std::log10(step) + TOLERANCE));
    return print("%.*g", std::min(std::max(digits, 1), 9), value);
  }
  const int decimals = -static_cast<int>(std::floor(std::log10(step) + TOLERANCE));
  return print("%.*f", std::max(decimals, 0), value);
}

std::vector<ScaleTick> linearTicks(double lower, double upper, std::size_t most)
{
  const double span = upper - lower;
  int exponent = static_cast<int>(std::floor(std::log10(span))) - 3;
  for (;; ++exponent) {
    for (const double factor : FACTORS) {
      const double step = factor * std::pow(10.0, exponent);
      const double first = std::ceil(lower / step - TOLERANCE);
      const double last = std::floor(upper / step + TOLERANCE);
      if (last - first + 1.0 > static_cast<double>(most)) {
        continue;
      }
      std::vector<ScaleTick> ticks;
      const double greatest = std::max(std::abs(lower), std::abs(upper));
      for (double i = first; i <= last; i += 1.0) {
        const double value = i * step;
        ticks.push_back({value, (value - lower) / span, labelOf(value, step, greatest)});
      }
      return ticks;
    }
  }
}

std::string logarithmicLabel(double value)
{
  if (value >= GREATEST_PLAIN || value < LEAST_PLAIN) {
    return print("%.*g", 1, value);
  }
  return print("%.*g", 6, value);
}

/// Ticks at each of the factors in every decade_step-th decade.
std::vector<ScaleTick> decadeTicks(double lower, double upper, int decade_step,
                                   std::size_t factor_count)
{
  std::vector<ScaleTick> ticks;
  const double from = std::log10(lower);
  const double span = std::log10(upper) - from;
  const int first = static_cast<int>(std::floor(from)) - 1;
  const int last = static_cast<int>(std::ceil(from + span));
  for (int decade = first; decade <= last; ++decade) {
    if (decade % decade_step != 0) {
      continue;
    }
    for (std::size_t i = 0; i < factor_count; ++i) {
      const double value = FACTORS[i] * std::pow(10.0, decade);
      const double position = (std::log10(value) - from) / span;
      if (position >= -TOLERANCE && position <= 1.0 + TOLERANCE) {
        ticks.push_back({value, position, logarithmicLabel(value)});
      }
    }
  }
  return ticks;
}

std::vector<ScaleTick> logarithmicTicks(double lower, double upper, std::size_t most)
{
  for (const std::size_t factor_count : {FACTORS.size(), std::size_t{1}}) {
    const std::vector<ScaleTick> ticks = decadeTicks(lower, upper, 1, factor_count);
    if (ticks.size() >= 3 && ticks.size() <= most) {
      return ticks;
    }
  }
  if (upper / lower <= 100.0) {  // Too few of them: evenly spaced values say more.
    std::vector<ScaleTick> ticks = linearTicks(lower, upper, most);
    for (ScaleTick& tick : ticks) {
      tick.position = std::log(tick.value / lower) / std::log(upper / lower);
    }
    return ticks;
  }
  int decade_step = 1;
  while (decadeTicks(lower, upper, decade_step, 1).size() > most) {
    ++decade_step;
  }
  return decadeTicks(lower, upper, decade_step, 1);
}

}  // namespace

std::vector<ScaleTick> scaleTicks(const CostColoring& coloring, const CostLimits& limits,
                                  std::size_t most)
{
  const double lower = std::min(limits.lower, limits.upper);
  const double upper = std::max(limits.lower, limits.upper);
  if (lower == upper) {
    return {{lower, 0.5, print("%.*g", 6, lower)}};
  }
  most = std::max(most, std::size_t{2});
  std::vector<ScaleTick> ticks = isLogarithmic(coloring, limits)
                                     ? logarithmicTicks(lower, upper, most)
                                     : linearTicks(lower, upper, most);
  for (ScaleTick& tick : ticks) {
    tick.position = std::min(std::max(tick.position, 0.0), 1.0);
  }
  return ticks;
}

}  // namespace rviz_mesh_plugin
