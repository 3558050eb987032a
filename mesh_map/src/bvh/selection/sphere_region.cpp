#include <mesh_map/bvh/closest/closest_point.h>
#include <mesh_map/bvh/selection/region.h>

#include <algorithm>
#include <cmath>

#include "base/vector3.h"

namespace mesh_map {

namespace {

/// Beyond it, all points of a mesh of floats (below 3.5e38) are as far from the center in double
/// precision, and squares would overflow soon.
constexpr double FAR_AWAY = 1e100;

/// Bound of the error of a distance to a triangle, relative to the size of what it is computed
/// from: closestPointOnTriangle() rounds less than 40 times, each by 2^-53 of that.
constexpr double ROUNDING = 1e-14;

}  // namespace

SphereRegion::SphereRegion(const std::array<double, 3>& center, double radius)
    : center_(center),
      radius_(radius),
      valid_(isFinite(center) && std::isfinite(radius) && radius >= 0.0)
{
}

double SphereRegion::distance(const std::array<double, 3>& way)
{
  const double size = std::max({std::abs(way[0]), std::abs(way[1]), std::abs(way[2])});
  return size < FAR_AWAY ? norm(way) : std::hypot(way[0], way[1], way[2]);
}

bool SphereRegion::contains(const std::array<double, 3>& point) const
{
  return valid_ && distance(point - center_) <= radius_;
}

Side SphereRegion::triangle(const float* corners) const
{
  unsigned inside = 0;
  for (unsigned k = 0; k < 3; ++k) {
    inside += contains({corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]}) ? 1 : 0;
  }
  if (inside == 3) {
    return Side::INSIDE;
  }
  const bool touches =
      inside > 0 ||
      (valid_ &&
       closestPointOnTriangle(corners, corners + 3, corners + 6, center_.data()).distance <=
           radius_);
  return touches ? Side::TOUCHING : Side::OUTSIDE;
}

Side SphereRegion::box(const Box& box) const
{
  if (!valid_) {
    return Side::OUTSIDE;
  }
  Vector3 near{}, far{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double below = box.lower[i] - center_[i], above = center_[i] - box.upper[i];
    near[i] = std::max({below, above, 0.0});
    far[i] = std::max(-below, -above);
  }
  const double least = distance(near), most = distance(far);
  const double rounding = ROUNDING * most;
  if (least > radius_ + rounding) {
    return Side::OUTSIDE;
  }
  return most + rounding < radius_ ? Side::INSIDE : Side::TOUCHING;
}

std::array<double, 3> SphereRegion::witness(const float* corners) const
{
  return closestPointOnTriangle(corners, corners + 3, corners + 6, center_.data()).position;
}

}  // namespace mesh_map
