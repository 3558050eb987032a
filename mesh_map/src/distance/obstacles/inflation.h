#pragma once

#include <mesh_map/base/large_array.h>

#include <cstdint>
#include <vector>

#include "distance/obstacles/obstacle_distance.h"

namespace mesh_map {

/// How costs fade with the distance d from an obstacle: lethal_value at 0, inscribed_value up to
/// inscribed_radius r, 0 beyond inflation_radius R, and between the two inscribed_value times
/// (cos(pi (d - r) / (R - r)) + 1) / 2, or exp(-cost_scaling (d - r)). Where R is below r, r
/// counts.
struct Fading
{
  double inscribed_radius = 0.25;  ///< meters
  double inflation_radius = 0.4;   ///< meters
  double lethal_value = 2.0;       ///< may be infinite
  double inscribed_value = 1.0;
  bool is_exponential = false;
  double cost_scaling = 1.0;  ///< 1/m
};

/// Cost per distance. The same bits for the same distance, wherever it is in the list.
LargeArray<float> fadingCosts(ArrayView<float> distances, const Fading& fading);

/// ObstacleDistance::direction of all vertices, times what fadingCosts would be for a lethal_value
/// and an inscribed_value of 1: 3 floats each.
LargeArray<float> repulsion(const ObstacleDistance& distance, Fading fading);
/// The same of some.
std::vector<float> repulsion(const ObstacleDistance& distance, ArrayView<std::uint32_t> vertices,
                             Fading fading);

/// These vertices and those next to them, ascending: where a change of distances can change
/// directions.
std::vector<std::uint32_t> withNeighbors(const FastMarchingMesh& mesh,
                                         ArrayView<std::uint32_t> vertices);

}  // namespace mesh_map
