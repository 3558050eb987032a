#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// The angle between two directions of length 1 in radians, 0 to pi, good for the smallest angles
/// too (the arc cosine of their product is not).
double angleBetween(const float* a, const float* b);

/// For each vertex the mean angle between its normal and those of its neighbors (3 floats each, of
/// length 1); 0 for one without neighbors. The order of the neighbors does not matter.
std::vector<float> meanEdgeAngles(ArrayView<float> normals, ArrayView<std::uint32_t> edges,
                                  const RowsView& neighbor_edges, unsigned threads = 0);

/// The angle between each normal (3 floats, of length 1) and a direction of length 1.
std::vector<float> anglesTo(ArrayView<float> normals, const std::array<double, 3>& direction,
                            unsigned threads = 0);

}  // namespace mesh_map
