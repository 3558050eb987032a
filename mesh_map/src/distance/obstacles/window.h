#pragma once

#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

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

  /// The point of the edge at a part of it, from 0 at its right end to 1 at its left end.
  Vector2 at(double part) const { return right_end + part * (left_end - right_end); }

  /// The point nearest to the source between two parts of the edge.
  Vector2 nearestBetween(double from, double to) const
  {
    const Vector2 edge = left_end - right_end;
    const double part = is_strip ? (edge[1] > 0.0 ? from : to) : -dot(right_end, edge) * inverse;
    return at(std::min(to, std::max(from, part)));
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
    return {crossedBy(right_ray, 0.0), crossedBy(left_ray, 1.0)};
  }

  /// Where a ray crosses the edge; where both ends are on the same side of it, the nearer one, and
  /// `otherwise` where it goes along the edge, or comes from behind.
  double crossedBy(const Vector2& ray, double otherwise) const
  {
    const double right = beside(ray, right_end), left = beside(ray, left_end);
    return left > right ? std::min(1.0, std::max(0.0, right / (right - left))) : otherwise;
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
