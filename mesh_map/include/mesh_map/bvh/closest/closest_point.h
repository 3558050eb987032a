#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace mesh_map {

/// The point of a face that is nearest to a query point.
struct SurfaceHit
{
  std::uint32_t face = NO_INDEX;  ///< NO_INDEX: nothing within the maximum distance
  std::array<double, 3> barycentric = {0.0, 0.0, 0.0};
  std::array<double, 3> position = {0.0, 0.0, 0.0};
  double distance = std::numeric_limits<double>::infinity();
};

/// The nearest point of one triangle (its face index is not set). Corners and point have 3 numbers
/// each. A triangle without area is treated as the segments it consists of. Beyond 1e140 m all
/// points of a triangle are as near. A point that is not finite has no finite distance.
SurfaceHit closestPointOnTriangle(const float* a, const float* b, const float* c,
                                  const double* point);

struct VertexHit
{
  std::uint32_t vertex = NO_INDEX;  ///< NO_INDEX: nothing within the maximum distance
  double distance = std::numeric_limits<double>::infinity();
};

/// The nearest vertex among those whose entry in `eligible` is not 0 (an empty array: among all)
/// within the maximum distance. Of several as near, the one of lowest index. A point that is not
/// finite finds nothing; neither does a maximum distance that is negative or NaN.
VertexHit closestVertex(ArrayView<float> positions, ArrayView<std::uint8_t> eligible,
                        const double* point, double max_distance);

}  // namespace mesh_map
