#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>

#include <cstdint>

namespace mesh_map {

/// All vertices in the cells of a regular grid: cells by x, then y, then z, vertices ascending
/// within each. What lies far from most of the mesh shares the outermost cells.
LargeArray<std::uint32_t> spatialOrder(ArrayView<float> positions, double cell_size,
                                       unsigned threads);

}  // namespace mesh_map
