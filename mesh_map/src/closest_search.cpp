#include "closest_search.h"

#include <algorithm>
#include <cmath>

#include "triangle_point.h"

namespace mesh_map {

SurfaceHit ClosestSearch::operator()(const double* point, const double* normal)
{
  point_ = point;
  normals_ = normal == nullptr ? NormalFilter() : NormalFilter(normal, options_.max_angle);
  distance_ = options_.max_distance;
  face_ = NO_INDEX;
  if (!isFinite(Vector3{point[0], point[1], point[2]}) || !normals_.valid() ||
      !(distance_ >= 0.0)) {
    return {};
  }
  if (triangle_ != NO_TRIANGLE) {
    offer(triangle_);
  }
  if (isFar()) {
    searchFar();
  } else {
    searchNear();
  }
  if (face_ == NO_INDEX) {
    return {};
  }
  const float* const found = corners(triangle_);
  SurfaceHit hit = surfacePoint(found, found + 3, found + 6, beta_gamma_[0], beta_gamma_[1]);
  hit.face = face_;
  hit.distance = distance_;
  return hit;
}

bool ClosestSearch::counts(std::size_t triangle) const
{
  return (options_.mask.empty() || options_.mask[bvh_.faces()[triangle]] != 0) &&
         normals_(corners(triangle));
}

void ClosestSearch::offer(std::size_t triangle)
{
  const float* const found = corners(triangle);
  const TrianglePoint nearest(found, found + 3, found + 6, point_);
  if (nearest.distance() > distance_) {
    return;
  }
  const std::uint32_t face = bvh_.faces()[triangle];
  if ((nearest.distance() < distance_ || face < face_) && counts(triangle)) {
    distance_ = nearest.distance();
    face_ = face;
    triangle_ = triangle;
    beta_gamma_ = {nearest.beta(), nearest.gamma()};
  }
}

bool ClosestSearch::isFar() const
{
  double away = 0.0, size = 0.0, numbers = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double center = bvh_.center()[i];
    away = std::max(away, std::abs(point_[i] - center));
    numbers = std::max({numbers, std::abs(point_[i]), std::abs(center)});
    size = std::max({size, std::abs(double{bvh_.lower()[i]}), std::abs(double{bvh_.upper()[i]})});
  }
  // Seen from 16 times its size, floats of 24 bits still tell a millionth of the mesh apart. Beyond
  // the other limits their squares would overflow or underflow.
  constexpr double MANY_SIZES = 16.0, LARGE = 1e17, SMALL = 1e-12;
  return !(away <= MANY_SIZES * size && numbers < LARGE && size < LARGE && size > SMALL);
}

}  // namespace mesh_map
