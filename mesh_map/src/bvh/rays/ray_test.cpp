#include "bvh/rays/ray_test.h"

#include <algorithm>

#include "base/simd.h"
#include "base/vector3.h"

namespace mesh_map {

namespace {

/// Smaller parts of an origin (meters) or a slope count as 0. Corners are floats, so no number that
/// meets() computes is then small enough to underflow: a sheared corner is 0 or above 1e-132, their
/// products and the residues of these are 0 or above 1e-300.
constexpr double SMALLEST_ORIGIN = 1e-60, SMALLEST_SLOPE = 1e-40;

double flush(double value, double smallest)
{
  return std::abs(value) < smallest ? 0.0 : value;
}

}  // namespace

RayTest::RayTest(const Ray& ray) : origin_(ray.origin), max_distance_(ray.max_distance)
{
  Vector3 d = ray.direction;
  const double sizes[3] = {std::abs(d[0]), std::abs(d[1]), std::abs(d[2])};
  const unsigned last =
      sizes[0] > sizes[1] ? (sizes[0] > sizes[2] ? 0 : 2) : (sizes[1] > sizes[2] ? 1 : 2);
  const double largest = sizes[last];
  if (!isFinite(origin_) || !isFinite(d) || largest == 0.0 || !(max_distance_ >= 0.0)) {
    return;
  }
  if (largest < 1e-100 || largest > 1e100) {  // whose squares would not be doubles
    const int exponent = std::ilogb(largest);
    for (double& component : d) {
      component = std::scalbn(component, -exponent);
    }
  }
  for (double& coordinate : origin_) {
    coordinate = flush(coordinate, SMALLEST_ORIGIN);
  }
  const double length = std::sqrt(dot(d, d));
  const Doubles2 first_two = Doubles2{d[0], d[1]} / length;
  direction_ = {first_two[0], first_two[1], d[2] / length};
  axes_ = {(last + 1) % 3, (last + 2) % 3, last};
  if (direction_[last] < 0.0) {
    std::swap(axes_[0], axes_[1]);
  }
  const Doubles2 slopes = Doubles2{d[axes_[0]], d[axes_[1]]} / d[last];
  shear_ = {flush(slopes[0], SMALLEST_SLOPE), flush(slopes[1], SMALLEST_SLOPE)};
  valid_ = true;
}

RayHit RayTest::operator()(const float* corners, bool back_faces) const
{
  RayHit hit;
  if (valid_ && meets(*this, corners, back_faces, &hit.distance, &hit.barycentric)) {
    hit.face = 0;
  }
  return hit;
}

}  // namespace mesh_map
