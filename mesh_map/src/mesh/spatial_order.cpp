#include "mesh/spatial_order.h"

#include <mesh_map/base/parallel.h>
#include <mesh_map/base/run_options.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

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

LargeArray<std::uint32_t> spatialOrder(ArrayView<float> positions, double cell_size,
                                       unsigned threads)
{
  const std::size_t count = positions.size() / 3;
  const std::array<double, 3> origin = middle(positions);
  LargeArray<std::uint64_t> keys(count);
  LargeArray<KeyedIndex> items(count);
  parallelEach(
      count, VERTICES_PER_CHUNK, threads, [=, out = keys.data(), to = items.data()](std::size_t v) {
        std::uint64_t key = 0;
        for (unsigned axis = 0; axis < 3; ++axis) {
          const double at = std::floor((positions[3 * v + axis] - origin[axis]) / cell_size);
          const auto cell =
              static_cast<std::int32_t>(std::clamp(at, -double{REACH}, double{REACH}));
          key = key << 21 | static_cast<std::uint32_t>(cell + REACH);
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
  LargeArray<std::uint32_t> order(count);
  for (std::size_t i = 0; i < count; ++i) {
    order[i] = items[i].index;
  }
  return order;
}

}  // namespace mesh_map
