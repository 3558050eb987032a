#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>

#include <cstdint>

#include "mesh/radius_statistics.h"

namespace mesh_map {

/// What a radius pass reads of vertices. Arrays that what is wanted does not need are empty.
struct RadiusAttributes
{
  LargeArray<float> heights;
  LargeArray<std::uint32_t> angles;  // in fixed point
  LargeArray<double> tips;           // of the normals, 3 each
};

/// Those of all vertices, the one of index order[i] in place i; without an order, of index i.
RadiusAttributes gatherAttributes(const RadiusQuery& query, ArrayView<std::uint32_t> order);

}  // namespace mesh_map
