#pragma once

#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/vector3.h"

namespace mesh_map {

/// One step of unfolding: where a point lies in the plane, beyond the line from a to b as seen from
/// the origin, at given squared distances from these.
inline bool placeBeyond(Vector2 a, Vector2 b, double from_a, double from_b, Vector2& result)
{
  const Vector2 side = b - a;
  const double squared = dot(side, side);
  if (!(squared > 0.0)) {
    return false;
  }
  const double along = 0.5 * (from_a + squared - from_b) / squared;
  const double height = std::sqrt(std::max(0.0, from_a / squared - along * along));
  // Counterclockwise from a to b around the origin: beyond is to the right of the side.
  result = {a[0] + along * side[0] + height * side[1], a[1] + along * side[1] - height * side[0]};
  return true;
}

/// A bundle of straight ways from one piece of an obstacle through an edge (J. Mitchell, D. Mount,
/// C. Papadimitriou: The Discrete Geodesic Problem, 1987): all faces that it has passed are
/// unfolded into a plane. From a point the ways are a cone with its tip at the origin. From an edge
/// they are a strip: upright, with the edge on the x axis.
struct Window
{
  std::uint32_t right, left;  // ends of the edge, looking away from the source
  std::uint32_t from;         // the third corner of the face that it comes through
  bool is_strip;
  std::uint32_t standing;       // faces passed since its distance grew
  double offset;                // from the obstacle to the source
  double nearest;               // the least distance of its part of the edge
  Vector2 right_end, left_end;  // where the ends lie
  Vector2 right_ray, left_ray;  // its limits: directions of length 1; of a strip, x in [0]

  /// What goes on from it through another edge.
  Window part(std::uint32_t to_right, std::uint32_t to_left, std::uint32_t coming_from,
              const Vector2& right_place, const Vector2& left_place, const Vector2& right_limit,
              const Vector2& left_limit) const
  {
    return {to_right, to_left,     coming_from, is_strip,    standing,  offset,
            nearest,  right_place, left_place,  right_limit, left_limit};
  }

  double distance(const Vector2& p) const { return is_strip ? p[1] : norm(p); }

  /// How far p lies to the left of a ray (meters; negative to its right).
  double beside(const Vector2& ray, const Vector2& p) const
  {
    return is_strip ? ray[0] - p[0] : cross(ray, p);
  }

  Vector2 rayTo(const Vector2& p) const { return is_strip ? Vector2{p[0], 0.0} : p / norm(p); }

  /// The least distance of the points between two.
  double nearestBetween(const Vector2& a, const Vector2& b) const
  {
    if (is_strip) {
      return std::min(a[1], b[1]);
    }
    const Vector2 side = b - a;
    const double squared = dot(side, side), along = -dot(a, side);
    return along <= 0.0       ? norm(a)
           : along >= squared ? norm(b)
                              : std::abs(cross(a, b)) / std::sqrt(squared);
  }

  /// Is there nothing between its limits? What lies this far aside of a limit is reached.
  bool isEmpty(double least, double far) const
  {
    return is_strip ? left_ray[0] > right_ray[0] - least * far
                    : cross(right_ray, left_ray) < least && dot(right_ray, left_ray) > 0.0;
  }

  /// Where its limits cross the edge, from 0 at its right end to 1 at its left end.
  std::array<double, 2> range() const
  {
    double from = 0.0, to = 1.0;
    if (const double of_right = beside(right_ray, right_end); of_right < 0.0) {
      const double of_left = beside(right_ray, left_end);
      from = of_left > of_right ? std::min(1.0, of_right / (of_right - of_left)) : 1.0;
    }
    if (const double of_left = beside(left_ray, left_end); of_left > 0.0) {
      const double of_right = beside(left_ray, right_end);
      to = of_left > of_right ? std::max(0.0, of_right / (of_right - of_left)) : 0.0;
    }
    return {from, to};
  }

  /// Where the way to p crosses the edge, from 0 at its right end to 1 at its left end.
  double crossing(const Vector2& p) const
  {
    const double r = is_strip ? right_end[0] - p[0] : -cross(p, right_end);
    const double l = is_strip ? p[0] - left_end[0] : cross(p, left_end);
    return r + l > 0.0 ? std::min(1.0, std::max(0.0, r / (r + l))) : 0.0;
  }
};

}  // namespace mesh_map
