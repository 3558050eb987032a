#include "bvh/rays/ray_beam.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mesh_map {

namespace {

/// Beyond this, floats would have to do with products that are no floats.
constexpr double LARGEST = 1e18;

/// Rounding of double precision, some times over: a bound of the error of a few operations.
constexpr double ROUNDING = 0x1p-48;

/// More than what floats round that have few digits, since they are so small.
constexpr double TINY = 1e-37;

constexpr double SMALLEST_SLOPE = 0x1p-40;

/// Whether all corners are the same to RayTest, so far away is the ray's origin. (Rounded
/// differences are monotonic.)
bool seesOnePoint(const Bvh& bvh, const RayTest& ray)
{
  constexpr double INF = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const double center = bvh.center()[k];
    const double lower = std::nextafter(center + bvh.lower()[k], -INF);
    const double upper = std::nextafter(center + bvh.upper()[k], INF);
    if (lower - ray.origin()[k] != upper - ray.origin()[k]) {
      return false;
    }
  }
  return true;
}

}  // namespace

Beam::Beam(const Bvh& bvh, const RayTest& ray)
{
  if (!ray.valid()) {
    return;
  }
  axes = ray.axes();
  const unsigned z = axes[2];
  const bool up = ray.direction()[z] > 0.0;
  const double sign = up ? 1.0 : -1.0;
  const double lower = bvh.lower()[z], upper = bvh.upper()[z], extent = upper - lower;
  const double origin_z = ray.origin()[z] - bvh.center()[z];
  const double before = sign * ((up ? lower : upper) - origin_z);
  const double room = sign * ((up ? upper : lower) - origin_z);
  // How far corners may be from the origin along z, and from the center of the mesh.
  const double reach_z = std::max(std::abs(lower), std::abs(upper));
  const double away_z = std::abs(origin_z) + reach_z + std::abs(bvh.center()[z]);
  depth_error = 0x1p-29 * extent + ROUNDING * away_z + TINY;
  if (room < -depth_error) {
    return;
  }
  skipped_depth = std::max(before, 0.0);
  depth_per_meter = std::abs(ray.direction()[z]);
  const double start_z = before > 0.0 ? (up ? lower : upper) : origin_z;
  const double point_z = bvh.center()[z] + start_z;
  reach = extent <= LARGEST && reach_z <= LARGEST ? Reach::FLOATS : Reach::ALL;

  // A hit that RayTest sees at 0 may lie behind the origin by the error of its depth.
  const double behind = before > 0.0 ? 0.0 : depth_error;
  const double z_error = behind + 0x1p-23 * std::abs(start_z);
  near_plane[2] = 4 * z + (up ? 0 : 12);
  far_plane[2] = 4 * z + (up ? 12 : 0);
  near_origin[2] = static_cast<float>(start_z + sign * z_error);
  far_origin[2] = static_cast<float>(start_z - sign * z_error);
  near_inverse[2] = static_cast<float>(sign * (1.0 - 0x1p-22));
  far_inverse[2] = static_cast<float>(sign * (1.0 + 0x1p-22));
  point[2] = static_cast<float>(point_z);

  // The other two axes, side by side.
  const auto across = [this](const auto& values) {
    return Doubles2{static_cast<double>(values[axes[0]]), static_cast<double>(values[axes[1]])};
  };
  const Doubles2 slope = {ray.shear()[0], ray.shear()[1]}, center = across(bvh.center());
  const Doubles2 corners_reach =
      maximum(absolute(across(bvh.lower())), absolute(across(bvh.upper())));
  const Doubles2 origin = across(ray.origin()) - center;
  const Doubles2 start = origin + (sign * skipped_depth) * slope;
  const Doubles2 error = ROUNDING * absolute(origin) + ROUNDING * absolute(slope) * away_z +
                         ROUNDING * (corners_reach + absolute(center)) +
                         (2.0 * SMALLEST_SLOPE * extent + behind + TINY);
  if (!both(absolute(start) - error <= corners_reach + 2.0 * extent)) {
    reach = Reach::NOTHING;  // it leaves the slab before it gets there
    return;
  }
  if (!both(error <= 0.1 * corners_reach) && seesOnePoint(bvh, ray)) {
    reach = Reach::NOTHING;
    return;
  }
  if (!both((error <= LARGEST) & (corners_reach <= LARGEST))) {
    reach = Reach::ALL;
  }
  const Doubles2 margin = error + 0x1p-23 * (absolute(start) + error);
  const Doubles2 side = timesSign(Doubles2{sign, sign}, slope);
  const Doubles2 inverse =
      timesSign(1.0 / maximum(absolute(slope), Doubles2{SMALLEST_SLOPE, SMALLEST_SLOPE}), side);
  const Doubles2 near_start = start + timesSign(margin, side);
  const Doubles2 far_start = start - timesSign(margin, side);
  const Doubles2 global = center + start;
  // Two roundings of corner_x - p_x, three of shear * (corner_z - p_z), one of the rest of p and of
  // the result: less than 2^-21 of the sum of their bounds.
  const Doubles2 corner_bound = 0x1p-21 * ((absolute(start) + corners_reach) +
                                           absolute(slope) * (std::abs(start_z) + reach_z)) +
                                0x1p-44 * (absolute(global) + std::abs(point_z)) + error;
  corner_error = static_cast<float>(std::max(corner_bound[0], corner_bound[1]) * (1.0 + 0x1p-22));
  for (unsigned k = 0; k < 2; ++k) {
    const unsigned lower_plane = 4 * axes[k], upper_plane = lower_plane + 12;
    near_plane[k] = side[k] > 0.0 ? lower_plane : upper_plane;
    far_plane[k] = side[k] > 0.0 ? upper_plane : lower_plane;
    near_origin[k] = static_cast<float>(near_start[k]);
    far_origin[k] = static_cast<float>(far_start[k]);
    near_inverse[k] = static_cast<float>((1.0 - 0x1p-22) * inverse[k]);
    far_inverse[k] = static_cast<float>((1.0 + 0x1p-22) * inverse[k]);
    shear[k] = static_cast<float>(slope[k]);
    point[k] = static_cast<float>(global[k]);
    point_rest[k] = static_cast<float>((global[k] - point[k]) - slope[k] * (point_z - point[2]));
  }
}

float Beam::depth(double distance) const
{
  const double ahead = distance * depth_per_meter;
  const double bound = ahead - skipped_depth + depth_error + ROUNDING * ahead;
  return static_cast<float>(std::min(bound, 1e30) * (1.0 + 0x1p-22));
}

}  // namespace mesh_map
