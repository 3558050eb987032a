#include "bvh/closest/normal_filter.h"

#include <algorithm>
#include <cmath>

namespace mesh_map {

namespace {

/// Radians by which an angle may seem larger than it is.
constexpr double ROUNDING = 1e-12;

/// A vector of length 1, whatever its length is (not 0).
Vector3 unit(const double* vector)
{
  const double largest = std::max({std::abs(vector[0]), std::abs(vector[1]), std::abs(vector[2])});
  const Vector3 scaled = {vector[0] / largest, vector[1] / largest, vector[2] / largest};
  return scaled / norm(scaled);
}

}  // namespace

NormalFilter::NormalFilter(const double* direction, double max_angle)
    : NormalFilter(unit(direction), max_angle)  // NaN for a direction of 0 or that is not finite
{
}

NormalFilter::NormalFilter(const Vector3& direction, double max_angle)
    : valid_(isFinite(direction) && max_angle >= 0.0),
      all_(max_angle >= PI),
      direction_(direction),
      max_angle_(max_angle),
      cosine_(all_ ? -1.0 : std::cos(max_angle))
{
}

bool NormalFilter::within(const float* corners) const
{
  const Vector3 n = triangleNormal(corners, corners + 3, corners + 6);
  const double length = norm(n), along = dot(n, direction_);
  if (!valid_ || !(length > 0.0)) {
    return false;
  }
  // A cosine is quick, but cannot tell small angles apart. Its error, as computed here, is far
  // below the margin, which in turn stands for more than ROUNDING radians.
  constexpr double MARGIN = 1e-9;
  const double above = along - cosine_ * length;
  if (std::abs(above) > MARGIN * length) {
    return above > 0.0;
  }
  return angleBetween(n, direction_) <= max_angle_ + ROUNDING;
}

}  // namespace mesh_map
