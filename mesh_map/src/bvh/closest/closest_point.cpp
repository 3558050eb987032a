#include <mesh_map/bvh/closest/closest_point.h>

#include <cmath>
#include <limits>

#include "bvh/closest/triangle_point.h"

namespace mesh_map {

SurfaceHit closestPointOnTriangle(const float* a, const float* b, const float* c,
                                  const double* point)
{
  const TrianglePoint nearest(a, b, c, point);
  SurfaceHit hit = surfacePoint(a, b, c, nearest.beta(), nearest.gamma());
  hit.distance = nearest.distance();
  return hit;
}

VertexHit closestVertex(ArrayView<float> positions, ArrayView<std::uint8_t> eligible,
                        const double* point, double max_distance)
{
  double best = std::numeric_limits<double>::infinity();
  std::uint32_t best_vertex = NO_INDEX;
  if (isFinite(point)) {
    for (std::size_t v = 0; v < positions.size() / 3; ++v) {
      const double x = positions[3 * v] - point[0];
      const double y = positions[3 * v + 1] - point[1];
      const double z = positions[3 * v + 2] - point[2];
      const double squared = x * x + y * y + z * z;
      if (squared < best && (eligible.empty() || eligible[v])) {
        best = squared;
        best_vertex = static_cast<std::uint32_t>(v);
      }
    }
  }
  const double distance = std::sqrt(best);
  if (best_vertex == NO_INDEX || !(distance <= max_distance)) {
    return {};
  }
  return {best_vertex, distance};
}

}  // namespace mesh_map
