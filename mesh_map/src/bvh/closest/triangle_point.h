#pragma once

#include <mesh_map/bvh/closest/bvh_closest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/require.h"
#include "base/vector3.h"

namespace mesh_map {

/// Distances from here on are scaled, since their squares could overflow.
constexpr double FAR_AWAY = 1e140;

/// The length of a vector, also of one whose square overflows. It never falls where a coordinate
/// grows away from 0, not even by rounding: scaling with a power of two changes no digit (what
/// underflows, is too small to count).
inline double lengthOf(const Vector3& gap)
{
  if (std::abs(gap[0]) + std::abs(gap[1]) + std::abs(gap[2]) < FAR_AWAY) {
    return norm(gap);
  }
  constexpr double SCALE = 0x1p-600;
  return norm(SCALE * gap) / SCALE;
}

/// The point of a triangle that is nearest to a query point.
///
/// It is the nearest of four candidates: the foot of the query on the plane, where that lies inside
/// (equations 1 and 2 of the paper), and the nearest point of each edge; of those as near, the
/// first. They are points of the triangle whatever is rounded, so a needle or a triangle without
/// area cannot seem nearer than it is. The distance is at least that to any box around the
/// triangle, as far as this is computed with the same roundings: coordinate by coordinate, the gap
/// is kept within those to the corners.
class TrianglePoint
{
 public:
  TrianglePoint(const float* a, const float* b, const float* c, const double* point)
  {
    const Vector3 u = difference(b, a), v = difference(c, a), side = v - u;
    const Vector3 from_a = gap(point, a), from_b = gap(point, b), from_c = gap(point, c);
    if (!(std::abs(from_a[0]) + std::abs(from_a[1]) + std::abs(from_a[2]) < FAR_AWAY)) {
      distance_ = lengthOf(from_a);  // from there, all points of a triangle are as near
      return;
    }
    // the foot, and how far along each edge its nearest point is (C. Ericson: Real-Time Collision
    // Detection, 2004, 5.1.2)
    const Vector3 n = cross(u, v);
    const Vector2 foot = barycentricWeights(u, v, n, from_a);
    const Pair at_a = Pair{dot(from_a, u), dot(from_a, v)} / Pair{dot(u, u), dot(v, v)};
    const double from_corner[] = {inUnit(at_a[0]), inUnit(at_a[1]),
                                  inUnit(dot(from_b, side) / dot(side, side))};
    // all comparisons with the NaN of a triangle without area are false
    // equation (2) of the paper
    const bool inside = (unsigned{foot[0] >= 0.0} & unsigned{foot[1] >= 0.0} &
                         unsigned{foot[0] + foot[1] <= 1.0}) != 0;
    const double beta[] = {inside ? foot[0] : from_corner[0], from_corner[0], 0.0,
                           1.0 - from_corner[2]};
    const double gamma[] = {inside ? foot[1] : 0.0, 0.0, from_corner[1], from_corner[2]};

    Pair squared[2] = {};
    for (std::size_t i = 0; i < 3; ++i) {
      const double low = std::min(std::min(from_a[i], from_b[i]), from_c[i]);
      const double high = std::max(std::max(from_a[i], from_b[i]), from_c[i]);
      for (std::size_t k = 0; k < 2; ++k) {
        const Pair betas = {beta[2 * k], beta[2 * k + 1]},
                   gammas = {gamma[2 * k], gamma[2 * k + 1]};
        Pair x = from_a[i] - betas * u[i] - gammas * v[i];
        x = x > low ? x : Pair{low, low};
        x = x < high ? x : Pair{high, high};
        squared[k] += x * x;
      }
    }
    const double squares[] = {squared[0][0], squared[0][1], squared[1][0], squared[1][1]};
    std::size_t best = 0;
    for (std::size_t k = 1; k < 4; ++k) {
      best = squares[k] < squares[best] ? k : best;
    }
    distance_ = std::sqrt(squares[best]);
    beta_ = beta[best];
    gamma_ = gamma[best];
  }

  /// NaN or infinity for a query that is not finite.
  double distance() const { return distance_; }

  /// Weights of the second and third corner.
  double beta() const { return beta_; }
  double gamma() const { return gamma_; }

 private:
  typedef double Pair __attribute__((vector_size(16)));

  static Vector3 gap(const double* point, const float* corner)
  {
    return {point[0] - corner[0], point[1] - corner[1], point[2] - corner[2]};
  }

  /// From 0 to 1; of the NaN of an edge without length, 0.
  static double inUnit(double value) { return std::min(1.0, value > 0.0 ? value : 0.0); }

  double distance_, beta_ = 0.0, gamma_ = 0.0;
};

/// A point of a triangle as a hit, without face and distance.
inline SurfaceHit surfacePoint(const float* a, const float* b, const float* c, double beta,
                               double gamma)
{
  SurfaceHit hit;
  hit.barycentric = {1.0 - beta - gamma, beta, gamma};
  for (std::size_t i = 0; i < 3; ++i) {
    hit.position[i] = a[i] + beta * (double{b[i]} - a[i]) + gamma * (double{c[i]} - a[i]);
  }
  return hit;
}

/// How many points so many numbers are. Throws std::invalid_argument for no multiple of 3.
inline std::size_t pointCount(ArrayView<double> points)
{
  require(points.size() % 3 == 0,
          "points of " + std::to_string(points.size()) + " numbers: 3 for each point");
  return points.size() / 3;
}

}  // namespace mesh_map
