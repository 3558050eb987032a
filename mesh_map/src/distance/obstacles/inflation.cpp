#include "distance/obstacles/inflation.h"

#include <mesh_map/base/parallel.h>

#include <cmath>

#include "base/unique.h"
#include "base/vector3.h"

namespace mesh_map {
namespace {

float cost(double distance, const Fading& fading)
{
  const double inner = fading.inscribed_radius;
  if (distance == 0.0) {
    return static_cast<float>(fading.lethal_value);
  }
  if (distance <= inner) {
    return static_cast<float>(fading.inscribed_value);
  }
  if (!(distance <= fading.inflation_radius)) {
    return 0.0f;
  }
  const double beyond = distance - inner;
  // the exponential of costmap_2d (D. Lu, D. Hershberger, W. Smart: Layered Costmaps, 2014)
  const double share =
      fading.is_exponential
          ? std::exp(-fading.cost_scaling * beyond)
          : 0.5 * (std::cos(PI * beyond / (fading.inflation_radius - inner)) + 1.0);
  return static_cast<float>(fading.inscribed_value * share);
}

/// Of one vertex; its costs have to be 1 where they are highest.
void store(const ObstacleDistance& distance, std::uint32_t v, const Fading& fading, float* vector)
{
  const float length = cost(distance.distances()[v], fading);
  const std::array<float, 3> direction =
      length > 0.0f ? distance.direction(v) : std::array<float, 3>{};
  for (unsigned axis = 0; axis < 3; ++axis) {
    vector[axis] = length * direction[axis];
  }
}

}  // namespace

LargeArray<float> fadingCosts(ArrayView<float> distances, const Fading& fading)
{
  LargeArray<float> costs(distances.size());
  parallelEach(distances.size(), 16384, 0,
               [&](std::size_t i) { costs[i] = cost(distances[i], fading); });
  return costs;
}

LargeArray<float> repulsion(const ObstacleDistance& distance, Fading fading)
{
  fading.lethal_value = fading.inscribed_value = 1.0;
  LargeArray<float> vectors(3 * distance.distances().size());
  parallelEach(distance.distances().size(), 16384, 0, [&](std::size_t v) {
    store(distance, static_cast<std::uint32_t>(v), fading, vectors.data() + 3 * v);
  });
  return vectors;
}

std::vector<float> repulsion(const ObstacleDistance& distance, ArrayView<std::uint32_t> vertices,
                             Fading fading)
{
  fading.lethal_value = fading.inscribed_value = 1.0;
  std::vector<float> vectors(3 * vertices.size());
  parallelEach(vertices.size(), 4096, 0, [&](std::size_t i) {
    store(distance, vertices[i], fading, vectors.data() + 3 * i);
  });
  return vectors;
}

std::vector<std::uint32_t> withNeighbors(const FastMarchingMesh& mesh,
                                         ArrayView<std::uint32_t> vertices)
{
  std::vector<std::uint32_t> result(vertices.begin(), vertices.end());
  for (const std::uint32_t v : vertices) {
    const bool is_closed = mesh.isClosed(v);  // then each b is an a, too
    for (const FastMarchingCorner& corner : mesh.corners(v)) {
      result.push_back(corner.a);
      if (!is_closed) {
        result.push_back(corner.b);
      }
    }
  }
  makeUnique(result);
  return result;
}

}  // namespace mesh_map
