#include "base/cost_summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

namespace rviz_mesh_plugin {
namespace {

/// Costs kept of large layers. The distance of their ranks is below 0.01 percent.
constexpr std::size_t KEPT_RANKS = 16385;

constexpr unsigned DIGIT_BITS = 11;
constexpr std::size_t DIGITS = std::size_t{1} << DIGIT_BITS;

/// An integer that is ordered as the number is.
std::uint32_t sortKey(float value)
{
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

float fromSortKey(std::uint32_t key)
{
  const std::uint32_t bits = key & 0x80000000u ? key & 0x7FFFFFFFu : ~key;
  float value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

constexpr std::array<unsigned, 3> SHIFTS{0, DIGIT_BITS, 2 * DIGIT_BITS};

std::size_t digitOf(std::uint32_t key, unsigned shift)
{
  return (key >> shift) & (DIGITS - 1);
}

/// Sorts by digits: several times faster than by comparisons.
void sortKeys(std::vector<std::uint32_t>& keys)
{
  // How many keys have a digit, then where the first of them goes.
  std::array<std::array<std::uint32_t, DIGITS>, SHIFTS.size()> starts{};
  for (const std::uint32_t key : keys) {
    for (std::size_t i = 0; i < SHIFTS.size(); ++i) {
      ++starts[i][digitOf(key, SHIFTS[i])];
    }
  }
  std::vector<std::uint32_t> sorted(keys.size());
  for (std::size_t i = 0; i < SHIFTS.size(); ++i) {
    std::uint32_t start = 0;
    for (std::uint32_t& entry : starts[i]) {
      start += std::exchange(entry, start);
    }
    for (const std::uint32_t key : keys) {
      sorted[starts[i][digitOf(key, SHIFTS[i])]++] = key;
    }
    keys.swap(sorted);
  }
}

/// Sorts @a keys.
std::vector<float> rankedCosts(std::vector<std::uint32_t>& keys)
{
  sortKeys(keys);
  const std::size_t kept = keys.size() <= EXACT_PERCENTILES ? keys.size() : KEPT_RANKS;
  std::vector<float> ranked(kept);
  for (std::size_t i = 0; i < kept; ++i) {
    const std::uint64_t rank =
        kept == keys.size() ? i : static_cast<std::uint64_t>(i) * (keys.size() - 1) / (kept - 1);
    ranked[i] = fromSortKey(keys[rank]);
  }
  return ranked;
}

}  // namespace

float CostSummary::percentile(double percent) const
{
  if (!ranked || ranked->empty()) {
    return 0.0f;
  }
  percent = std::min(std::max(percent, 0.0), 100.0);
  const double rank = percent / 100.0 * static_cast<double>(ranked->size() - 1);
  const auto first = static_cast<std::size_t>(rank);
  const double lower = (*ranked)[first];
  const double upper = (*ranked)[std::min(first + 1, ranked->size() - 1)];
  return static_cast<float>(lower + (rank - static_cast<double>(first)) * (upper - lower));
}

CostSummary summarizeCosts(const std::vector<float>& costs)
{
  CostSummary summary;
  std::vector<std::uint32_t> keys(costs.size());
  std::size_t finite = 0;
  float least_positive = std::numeric_limits<float>::max();
  for (const float cost : costs) {
    if (std::isfinite(cost)) {
      keys[finite++] = sortKey(cost);
      if (cost > 0.0f) {
        ++summary.positive;
        least_positive = std::min(least_positive, cost);
      }
    } else if (std::isnan(cost)) {
      ++summary.unknown;
    } else {
      ++summary.lethal;
    }
  }
  keys.resize(finite);
  summary.finite = keys.size();
  summary.least_positive = summary.positive > 0 ? least_positive : 0.0f;
  summary.limits = CostLimits{0.0f, 0.0f};
  if (summary.finite > 0) {
    auto ranked = std::make_shared<const std::vector<float>>(rankedCosts(keys));
    summary.limits = {ranked->front(), ranked->back()};
    summary.ranked = std::move(ranked);
  }
  return summary;
}

}  // namespace rviz_mesh_plugin
