#pragma once

#include <mesh_map/base/array_view.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/vector3.h"
#include "bvh/selection/region_clip.h"

namespace mesh_map {

/// Heights above the ground between which a body is, both outside of it.
struct BodyHeights
{
  double low, high;
};

/// Where bodies without a radius are that stand anywhere on a face: between two planes parallel to
/// it, above (z) the three cells of its corners.
class FaceBand
{
 public:
  /// Steeper faces have no cells: sine of 1.2 degrees.
  static constexpr double LEAST_LEVEL = 0.02;

  /// `slack`: by so much in plan cells are larger, so that nothing is lost between them.
  FaceBand(const MeshView& mesh, std::size_t face, const BodyHeights& heights, double slack);

  /// Whether the face has cells.
  bool valid() const { return valid_; }

  /// A box around it.
  const Vector3& lower() const { return lower_; }
  const Vector3& upper() const { return upper_; }

  /// Of the corners in `wanted` (bits 1, 2, 4) those above whose cells a triangle (9 floats) is.
  unsigned cornersBelow(const float* triangle, unsigned wanted) const;

 private:
  /// How far above the plane of the face a point is.
  double heightOf(const float* point) const
  {
    return point[2] - origin_[2] - slope_[0] * (point[0] - origin_[0]) -
           slope_[1] * (point[1] - origin_[1]);
  }

  /// In front of it: left of a directed line in plan through a point (or right, for -1), or within
  /// `slack` of it.
  static Plane upright(const Vector2& normal, const Vector3& through, double slack);

  bool valid_ = false;
  BodyHeights heights_;
  double slack_;
  Vector3 origin_{}, lower_{}, upper_{};
  Vector2 slope_{};
  Plane low_{}, high_{};
  std::array<Plane, 3> sides_{};  // between corner k and the next one
  std::array<Plane, 3>
      bisectors_{};  // in front of each is what is nearer to k than to the next one
};

/// A body with a radius that stands at a vertex.
class VertexBand
{
 public:
  VertexBand(const float* vertex, const BodyHeights& heights, double radius)
      : foot_(pointOf(vertex)), heights_(heights), radius_(radius)
  {
  }

  Vector3 lower() const
  {
    return {foot_[0] - radius_, foot_[1] - radius_, foot_[2] + heights_.low};
  }
  Vector3 upper() const
  {
    return {foot_[0] + radius_, foot_[1] + radius_, foot_[2] + heights_.high};
  }

  /// Whether a triangle (9 floats) is in it.
  bool meets(const float* triangle) const;

  /// Whether a triangle, at any height, is within the radius in plan.
  bool isNear(const float* triangle) const;

  /// Whether a point is within the radius in plan, by more than rounding.
  bool isWithin(const float* point) const
  {
    const Vector2 offset = {point[0] - foot_[0], point[1] - foot_[1]};
    return dot(offset, offset) < (1.0 - 1e-6) * radius_ * radius_;
  }

  /// How far in plan a point is from the vertex, and how far above it.
  double distanceTo(const float* point) const
  {
    return std::hypot(point[0] - foot_[0], point[1] - foot_[1]);
  }
  double heightOf(const float* point) const { return point[2] - foot_[2]; }

 private:
  /// Whether a convex polygon is within the radius in plan.
  bool isNear(const ClippedTriangle& polygon) const;

  Vector3 foot_;
  BodyHeights heights_;
  double radius_;
};

}  // namespace mesh_map
