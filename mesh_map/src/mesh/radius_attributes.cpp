#include "mesh/radius_attributes.h"

#include <mesh_map/base/parallel.h>

#include <cstddef>

#include "base/fixed_point.h"
#include "base/vector3.h"

namespace mesh_map {

namespace {

constexpr std::size_t VERTICES_PER_CHUNK = 32768;
constexpr unsigned ANY_HEIGHT_DIFFERENCE = HEIGHT_DIFFERENCE | HEIGHT_DIFFERENCE_AROUND;
constexpr unsigned ANY_ROUGHNESS = ROUGHNESS | ROUGHNESS_AROUND;

}  // namespace

RadiusAttributes gatherAttributes(const RadiusQuery& query, ArrayView<std::uint32_t> order)
{
  const std::size_t count = query.positions.size() / 3;
  const bool heights = (query.wanted & ANY_HEIGHT_DIFFERENCE) != 0;
  const bool angles = (query.wanted & ANY_ROUGHNESS) != 0, normals = (query.wanted & RIDGE) != 0;
  RadiusAttributes all;
  all.heights.resize(heights ? count : 0);
  all.angles.resize(angles ? count : 0);
  all.tips.resize(normals ? 3 * count : 0);
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
      for (std::size_t axis = 0; axis < 3; ++axis) {
        all.tips[3 * i + axis] = double{position[axis]} + query.normals[3 * v + axis];
      }
    }
  });
  return all;
}

}  // namespace mesh_map
