#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>

#include <cstdint>

#include "mesh/radius_statistics.h"

namespace mesh_map {

/// Position + normal of a vertex, not added: of vertices near to each other, the differences of
/// both are as exact as their size allows. All are divided by RadiusAttributes::tip_scale.
struct alignas(32) Tip
{
  float position[4], normal[4];  // the last ones are 0
};

/// What a radius pass reads of vertices. Arrays that what is wanted does not need are empty.
struct RadiusAttributes
{
  LargeArray<float> heights;
  LargeArray<std::uint32_t> angles;  // in fixed point
  LargeArray<Tip> tips;
  double tip_scale = 1.0;  // meters: a power of 2, above the distances of tips within the radius
};

/// Those of all vertices, the one of index order[i] in place i; without an order, of index i.
RadiusAttributes gatherAttributes(const RadiusQuery& query, ArrayView<std::uint32_t> order);

}  // namespace mesh_map
