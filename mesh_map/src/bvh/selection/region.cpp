#include <mesh_map/bvh/selection/region.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/require.h"
#include "bvh/closest/triangle_point.h"
#include "bvh/selection/region_clip.h"

namespace mesh_map {

SphereRegion::SphereRegion(const std::array<double, 3>& center, double radius)
    : center_(center), radius_(radius)
{
  valid_ = isFinite(center) && std::isfinite(radius) && radius >= 0.0;
}

bool SphereRegion::contains(const std::array<double, 3>& point) const
{
  return valid_ && lengthOf(point - center_) <= radius_;
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

std::array<double, 3> SphereRegion::witness(const float* corners) const
{
  return closestPointOnTriangle(corners, corners + 3, corners + 6, center_.data()).position;
}

namespace {

/// A plane that all points of a mesh are as clearly in front of, or behind, as of one further away.
constexpr double FARTHEST_PLANE = 1e200;

/// With a normal of length 1. All zero where that cannot be.
Plane scaled(const Plane& plane)
{
  // In two steps, so that neither squares nor quotients overflow.
  const double size = std::max({std::abs(plane[0]), std::abs(plane[1]), std::abs(plane[2])});
  if (!(size > 0.0) || !isFinite({plane[0], plane[1], plane[2]}) || !std::isfinite(plane[3])) {
    return {};
  }
  const double a = plane[0] / size, b = plane[1] / size, c = plane[2] / size;
  const double length = std::sqrt(a * a + b * b + c * c);
  const double d = plane[3] / size / length;
  return {a / length, b / length, c / length,
          std::min(FARTHEST_PLANE, std::max(-FARTHEST_PLANE, d))};
}

}  // namespace

ConvexRegion::ConvexRegion(const std::vector<Plane>& planes)
{
  require(!planes.empty() && planes.size() <= MAX_PLANES,
          "a convex region has 1 to " + std::to_string(MAX_PLANES) + " planes, not " +
              std::to_string(planes.size()));
  for (const Plane& plane : planes) {
    planes_.push_back(scaled(plane));
    valid_ = valid_ && planes_.back() != Plane{};
  }
}

ConvexRegion ConvexRegion::box(const std::array<double, 3>& center,
                               const std::array<std::array<double, 3>, 3>& axes,
                               const std::array<double, 3>& half_size)
{
  std::vector<Plane> planes;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3& axis = axes[i];
    const double middle = dot(axis, center);
    const double half = half_size[i] >= 0.0 ? half_size[i] : std::nan("");
    planes.push_back({axis[0], axis[1], axis[2], half - middle});
    planes.push_back({-axis[0], -axis[1], -axis[2], half + middle});
  }
  return ConvexRegion(planes);
}

bool ConvexRegion::contains(const std::array<double, 3>& point) const
{
  return valid_ && std::all_of(planes_.begin(), planes_.end(), [&point](const Plane& plane) {
           return height(plane, point[0], point[1], point[2]) >= 0.0;
         });
}

Side ConvexRegion::triangle(const float* corners) const
{
  return triangle(corners, ALL_PLANES);
}

Side ConvexRegion::triangle(const float* corners, std::uint32_t cutting) const
{
  if (!valid_) {
    return Side::OUTSIDE;
  }
  const PlaneSides sides = planeSides(planes_, cutting, corners);
  if (sides.outside != 0) {
    return Side::OUTSIDE;
  }
  if (sides.cutting == 0) {
    return Side::INSIDE;
  }
  if ((sides.cutting & (sides.cutting - 1)) == 0) {
    return Side::TOUCHING;  // one plane alone leaves something: a corner
  }
  ClippedTriangle rest(corners);
  rest.cut(planes_, sides.cutting);
  return rest.empty() ? Side::OUTSIDE : Side::TOUCHING;
}

std::array<double, 3> ConvexRegion::witness(const float* corners) const
{
  ClippedTriangle rest(corners);
  for (const Plane& plane : planes_) {
    ClippedTriangle cut = rest;
    cut.cut(plane);
    rest = cut.empty() ? rest : cut;
  }
  return rest.center();
}

}  // namespace mesh_map
