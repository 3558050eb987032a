#pragma once

#include <mesh_map/bvh/rays/bvh_rays.h>

#include <array>
#include <cmath>
#include <limits>

namespace mesh_map {

/// a * d - b * c where the products nearly cancel: the sign is exact, the value is to a few bits of
/// double precision (T. J. Dekker: A floating-point technique for extending the available
/// precision, 1971; the residues of products and sums are carried along).
inline double cancellingDeterminant(double a, double b, double c, double d)
{
  const double p = a * d, q = b * c;
  const double p_rest = std::fma(a, d, -p), q_rest = std::fma(b, c, -q);
  const double high = p - q;  // exact: the products are within a factor of two
  const double rest = p_rest - q_rest;
  const double q_part = p_rest - rest;
  const double rest_rest = (p_rest - (rest + q_part)) + (q_part - q_rest);
  const double sum = high + rest;
  const double rest_part = sum - high;
  return sum + (((high - (sum - rest_part)) + (rest - rest_part)) + rest_rest);
}

/// a * d - b * c with its exact sign (nothing underflows, see RayTest::RayTest) and an error of at
/// most 2^-32 of it. Exchanging (a, b) with (c, d) changes the sign and nothing else.
inline double determinant(double a, double b, double c, double d)
{
  const double p = a * d, q = b * c;
  const double difference = p - q;
  // Rounding is at most 2^-53 of either product and of the difference.
  if (std::abs(difference) > 0x1p-20 * (std::abs(p) + std::abs(q))) {
    return difference;
  }
  return cancellingDeterminant(a, b, c, d);
}

/// What RayTest says, for a valid ray. Writes the distance and the weights only if it is a hit.
///
/// What pruning relies on: a triangle is hit if and only if the three sheared corners, as rounded
/// here, span a triangle with area around the zero of their plane, the border included. Rounding
/// moves a sheared corner by less than 2^-50 (|corner - origin| along its axis + |shear| * |corner
/// - origin| along the last). The last coordinate of the hit is that of the point of the triangle
/// at zero up to 2^-30 of the extent of the triangle and 2^-50 of its distance.
inline bool meets(const RayTest& ray, const float* corners, bool back_faces, double* distance,
                  std::array<double, 3>* weights)
{
  const auto [x, y, z] = ray.axes();
  const auto& origin = ray.origin();
  const auto [shear_x, shear_y] = ray.shear();
  const double az = corners[z] - origin[z];
  const double bz = corners[z + 3] - origin[z];
  const double cz = corners[z + 6] - origin[z];
  const double ax = (corners[x] - origin[x]) - shear_x * az;
  const double bx = (corners[x + 3] - origin[x]) - shear_x * bz;
  const double cx = (corners[x + 6] - origin[x]) - shear_x * cz;
  const double ay = (corners[y] - origin[y]) - shear_y * az;
  const double by = (corners[y + 3] - origin[y]) - shear_y * bz;
  const double cy = (corners[y + 6] - origin[y]) - shear_y * cz;
  // The scaled barycentric coordinates U, V, W of the sheared corners (Woop et al. 2013).
  const double u = determinant(cx, cy, bx, by);
  const double v = determinant(ax, ay, cx, cy);
  const double w = determinant(bx, by, ax, ay);
  // Written so that a NaN, from an origin near the largest doubles, is no hit.
  if (!(u >= 0.0 && v >= 0.0 && w >= 0.0) && !(back_faces && u <= 0.0 && v <= 0.0 && w <= 0.0)) {
    return false;
  }
  const double sum = u + v + w;
  if (sum == 0.0 || !(std::abs(sum) <= std::numeric_limits<double>::max())) {
    return false;
  }
  const double v_weight = v / sum, w_weight = w / sum;
  // Exact where all corners have the same coordinate.
  const double along = az + (v_weight * (bz - az) + w_weight * (cz - az));
  const double t = along / ray.direction()[z] + 0.0;  // never -0
  if (!(t >= 0.0 && t <= ray.maxDistance() && t <= std::numeric_limits<double>::max())) {
    return false;
  }
  *distance = t;
  *weights = {u / sum, v_weight, w_weight};
  return true;
}

}  // namespace mesh_map
