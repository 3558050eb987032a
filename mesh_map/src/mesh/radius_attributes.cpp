#include "mesh/radius_attributes.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/fixed_point.h"
#include "base/vector3.h"

namespace mesh_map {

namespace {

constexpr std::size_t VERTICES_PER_CHUNK = 32768;
constexpr unsigned ANY_HEIGHT_DIFFERENCE = HEIGHT_DIFFERENCE | HEIGHT_DIFFERENCE_AROUND |
                                           SURFACE_HEIGHT_DIFFERENCE |
                                           SURFACE_HEIGHT_DIFFERENCE_AROUND;
constexpr unsigned ANY_ROUGHNESS = ROUGHNESS | ROUGHNESS_AROUND;

/// Of the box around all positions.
double diagonal(ArrayView<float> positions)
{
  if (positions.empty()) {
    return 0.0;
  }
  std::array<float, 3> lowest = {positions[0], positions[1], positions[2]}, highest = lowest;
  for (std::size_t i = 0; i < positions.size(); i += 3) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], positions[i + axis]);
      highest[axis] = std::max(highest[axis], positions[i + axis]);
    }
  }
  double squared = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    squared += (double{highest[axis]} - lowest[axis]) * (double{highest[axis]} - lowest[axis]);
  }
  return std::sqrt(squared);
}

/// The tips of two normals are at most 2 m farther apart than the vertices.
double tipScale(const RadiusQuery& query)
{
  const double largest = std::min(query.radius, diagonal(query.positions)) + 2.0;
  return std::exp2(std::ceil(std::log2(largest)));
}

}  // namespace

RadiusAttributes gatherAttributes(const RadiusQuery& query, ArrayView<std::uint32_t> order)
{
  const std::size_t count = query.positions.size() / 3;
  const bool heights = (query.wanted & ANY_HEIGHT_DIFFERENCE) != 0;
  const bool angles = (query.wanted & ANY_ROUGHNESS) != 0, normals = (query.wanted & RIDGE) != 0;
  RadiusAttributes all;
  all.heights.resize(heights ? count : 0);
  all.angles.resize(angles ? count : 0);
  all.tips.resize(normals ? count : 0);
  all.tip_scale = normals ? tipScale(query) : 1.0;
  const double part = 1.0 / all.tip_scale;
  parallelEach(count, VERTICES_PER_CHUNK, query.threads, [&, up = query.up](std::size_t i) {
    const std::size_t v = order.empty() ? i : order[i];
    const float* const position = query.positions.data() + 3 * v;
    if (heights) {
      all.heights[i] = static_cast<float>(dot(pointOf(position), up));
    }
    if (angles) {
      all.angles[i] = toFixed(query.angles[v], ANGLE_UNITS);
    }
    if (normals) {
      Tip tip{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        tip.position[axis] = static_cast<float>(part * position[axis]);
        tip.normal[axis] = static_cast<float>(part * query.normals[3 * v + axis]);
      }
      all.tips[i] = tip;
    }
  });
  return all;
}

}  // namespace mesh_map
