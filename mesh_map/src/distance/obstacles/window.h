#pragma once

#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/simd.h"
#include "base/vector3.h"

namespace mesh_map {

/// A vertex as far as this (radians) aside of a window is reached by it: more than what is narrower
/// than WINDOW_WIDTH or lies behind a vertex with less than BEND above a full turn is hidden.
constexpr double WINDOW_ASIDE = 4e-6;
constexpr double WINDOW_WIDTH = 1e-6;

/// A bundle of straight ways from one piece of an obstacle through an edge (J. Mitchell, D. Mount,
/// C. Papadimitriou: The Discrete Geodesic Problem, 1987): all faces that it has passed are
/// unfolded into a plane. From a point the ways are a cone with its tip at the origin. From an edge
/// they are a strip: upright, with the edge on the x axis.
struct Window
{
  std::uint32_t right, left;  // ends of the edge, looking away from the source
  std::uint32_t from;         // the third corner of the face that it comes through
  bool is_strip;
  bool may_leave;          // to where no distances are wanted
  std::uint32_t standing;  // faces passed since its distance grew
  double offset;           // from the obstacle to the source
  double nearest;          // squared: the least distance of its part of the edge from the source
  double length;           // squared, of the edge
  double inverse;          // 1 / length
  Vector2 right_end, left_end;  // where the ends lie
  Vector2 right_ray, left_ray;  // its limits: directions of length 1; of a strip, x in [0]

  /// One step of unfolding: where the third corner of the next face lies, at given squared
  /// distances from both ends.
  Vector2 placeBeyond(double from_right, double from_left) const
  {
    const Vector2 side = left_end - right_end;
    const double along = 0.5 * (from_right + length - from_left) * inverse;
    const double height = std::sqrt(std::max(0.0, from_right * inverse - along * along));
    return {right_end[0] + along * side[0] + height * side[1],
            right_end[1] + along * side[1] - height * side[0]};
  }

  /// On through the edge from its right end to the third corner of the next face.
  void turnRight(std::uint32_t beyond, const Vector2& place, double squared_length)
  {
    from = left;
    left = beyond;
    left_end = place;
    length = squared_length;
    inverse = 1.0 / squared_length;
  }

  void turnLeft(std::uint32_t beyond, const Vector2& place, double squared_length)
  {
    from = right;
    right = beyond;
    right_end = place;
    length = squared_length;
    inverse = 1.0 / squared_length;
  }

  double distance(const Vector2& p) const { return is_strip ? p[1] : norm(p); }
  double squaredDistance(const Vector2& p) const { return is_strip ? p[1] * p[1] : dot(p, p); }

  /// How far p lies to the left of a ray (meters; negative to its right).
  double beside(const Vector2& ray, const Vector2& p) const
  {
    return is_strip ? ray[0] - p[0] : cross(ray, p);
  }

  Vector2 rayTo(const Vector2& p) const
  {
    return is_strip ? Vector2{p[0], 0.0} : (1.0 / norm(p)) * p;
  }

  /// The part of the line through both ends that is nearest to the source.
  double nearestPart() const
  {
    const Vector2 edge = left_end - right_end;
    return is_strip ? (edge[1] > 0.0 ? 0.0 : 1.0) : -dot(right_end, edge) * inverse;
  }

  /// The squared distances of two points of the edge from the source, at two parts of it.
  Doubles2 squaredDistances(Doubles2 parts) const
  {
    const Doubles2 x = right_end[0] + parts * (left_end[0] - right_end[0]);
    const Doubles2 y = right_end[1] + parts * (left_end[1] - right_end[1]);
    return is_strip ? y * y : x * x + y * y;
  }

  /// Is there nothing between its limits? What lies this far aside of a limit is reached.
  bool isEmpty(double least, double far) const
  {
    return is_strip ? left_ray[0] > right_ray[0] - least * far
                    : cross(right_ray, left_ray) < least && dot(right_ray, left_ray) > 0.0;
  }

  /// Where its limits cross the edge, from 0 at its right end to 1 at its left end; an end, where
  /// both ends are on the same side of a limit, or it goes along the edge, or comes from behind.
  Doubles2 range() const
  {
    const Doubles2 of_right = {beside(right_ray, right_end), beside(left_ray, right_end)};
    const Doubles2 of_left = {beside(right_ray, left_end), beside(left_ray, left_end)};
    const Doubles2 crossed = of_right / (of_right - of_left), all = {0.0, 1.0};
    return of_left > of_right ? minimum(maximum(crossed, Doubles2{}), Doubles2{1.0, 1.0}) : all;
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
