#include "mesh/radius_grid.h"

#include <mesh_map/base/parallel.h>
#include <mesh_map/base/run_options.h>

#include <algorithm>
#include <cmath>

#include "base/radix_sort.h"
#include "base/run.h"

namespace mesh_map {
namespace {

constexpr std::size_t VERTICES_PER_CHUNK = 32768;

/// Cells on either side of the origin; three such coordinates fit into 64 bits.
constexpr std::int32_t REACH = (1 << 20) - 1;

/// A place in the middle of the mesh that a few far away vertices do not move.
std::array<double, 3> middle(ArrayView<float> positions)
{
  constexpr std::size_t samples = 999;
  const std::size_t count = positions.size() / 3;
  const std::size_t step = std::max<std::size_t>(1, count / samples);
  std::array<double, 3> result = {0.0, 0.0, 0.0};
  for (unsigned axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    for (std::size_t v = 0; v < count; v += step) {
      values.push_back(positions[3 * v + axis]);
    }
    const auto median = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), median, values.end());
    result[axis] = *median;
  }
  return result;
}

}  // namespace

RadiusGrid::RadiusGrid(ArrayView<float> positions, double cell_size, unsigned threads)
    : cells_per_meter_(1.0 / cell_size), origin_(middle(positions)), order_(positions.size() / 3)
{
  sort(positions, threads);
  cut(positions, threads);
}

std::int32_t RadiusGrid::coordinate(double position, unsigned axis) const
{
  const double at = std::floor((position - origin_[axis]) * cells_per_meter_);
  return static_cast<std::int32_t>(std::clamp(at, -double{REACH}, double{REACH}));
}

void RadiusGrid::sort(ArrayView<float> positions, unsigned threads)
{
  const std::size_t count = order_.size();
  LargeArray<std::uint64_t> keys(count);
  LargeArray<KeyedIndex> items(count);
  parallelEach(count, VERTICES_PER_CHUNK, threads,
               [&, out = keys.data(), to = items.data()](std::size_t v) {
                 std::uint64_t key = 0;
                 for (unsigned axis = 0; axis < 3; ++axis) {
                   const std::int32_t at = coordinate(positions[3 * v + axis], axis) + REACH;
                   key = key << 21 | static_cast<std::uint32_t>(at);
                 }
                 out[v] = key;
                 to[v] = {static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(v)};
               });
  Run run({threads, nullptr, {}});
  sortByKey(items, run, 0.0);
  parallelEach(count, VERTICES_PER_CHUNK, threads, [&keys, to = items.data()](std::size_t i) {
    to[i].key = static_cast<std::uint32_t>(keys[to[i].index] >> 32);
  });
  sortByKey(items, run, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    order_[i] = items[i].index;
  }
}

void RadiusGrid::cut(ArrayView<float> positions, unsigned threads)
{
  Coordinates last = {};
  for (std::uint32_t i = 0; i < order_.size(); ++i) {
    const float* const position = positions.data() + 3 * std::size_t{order_[i]};
    const Coordinates at = {coordinate(position[0], 0), coordinate(position[1], 1),
                            coordinate(position[2], 2)};
    if (cells_.empty() || at != last) {
      cells_.push_back({at, i, {}, {}});
      last = at;
    }
  }
  parallelEach(cells_.size(), 1024, threads, [this, positions](std::size_t c) {
    Cell& cell = cells_[c];
    for (std::uint32_t i = cell.first; i < end(c); ++i) {
      const float* const position = positions.data() + 3 * std::size_t{order_[i]};
      for (unsigned axis = 0; axis < 3; ++axis) {
        const bool first = i == cell.first;
        cell.lowest[axis] = first ? position[axis] : std::min(cell.lowest[axis], position[axis]);
        cell.highest[axis] = first ? position[axis] : std::max(cell.highest[axis], position[axis]);
      }
    }
  });
}

void RadiusGrid::around(std::size_t cell, double radius, std::vector<Range>& found) const
{
  constexpr double slack = 1.0 + 1e-6;  // more than all rounding
  const Cell& center = cells_[cell];
  Coordinates lowest, highest;
  for (unsigned axis = 0; axis < 3; ++axis) {
    lowest[axis] = coordinate(center.lowest[axis] - radius * slack, axis);
    highest[axis] = coordinate(center.highest[axis] + radius * slack, axis);
  }
  const auto tooFar = [&](const Cell& other) {
    double squared = 0.0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const double gap = std::max({double{center.lowest[axis]} - other.highest[axis],
                                   double{other.lowest[axis]} - center.highest[axis], 0.0});
      squared += gap * gap;
    }
    return squared > radius * radius * slack;
  };
  Coordinates from = lowest;
  auto at = cells_.begin();
  while (true) {
    at = std::lower_bound(at, cells_.end(), from,
                          [](const Cell& c, const Coordinates& key) { return c.at < key; });
    if (at == cells_.end() || at->at[0] > highest[0]) {
      return;
    }
    if (at->at[0] == from[0]) {
      for (; at != cells_.end() && at->at[0] == from[0] && at->at[1] <= highest[1]; ++at) {
        if (at->at[2] >= lowest[2] && at->at[2] <= highest[2] && !tooFar(*at)) {
          found.push_back(this->cell(static_cast<std::size_t>(at - cells_.begin())));
        }
      }
      ++from[0];
    } else {
      from[0] = at->at[0];  // nothing in between
    }
  }
}

}  // namespace mesh_map
