#pragma once

#include <mesh_map/bvh/selection/region.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/vector3.h"

namespace mesh_map {

/// Bound of the rounding of height() and of the sums below, relative to the size of its terms:
/// there are less than 8 roundings, each by 2^-53 of that.
constexpr double HEIGHT_ROUNDING = 8.0 / 9007199254740992.0;

/// A bit for each plane.
constexpr std::uint32_t ALL_PLANES = 0xFFFFFFFFu;

/// How far in front of a plane a point lies.
inline double height(const Plane& plane, double x, double y, double z)
{
  return plane[0] * x + plane[1] * y + plane[2] * z + plane[3];
}

/// The size of the terms of height() for points whose coordinates are at most that large.
inline double heightTerms(const Plane& plane, const Vector3& largest)
{
  return std::abs(plane[0]) * largest[0] + std::abs(plane[1]) * largest[1] +
         std::abs(plane[2]) * largest[2] + std::abs(plane[3]);
}

/// What planes leave of a triangle: a convex polygon, or a segment or point (I. Sutherland,
/// G. Hodgman: Reentrant Polygon Clipping, 1974).
class ClippedTriangle
{
 public:
  /// Each plane cuts off one corner of a convex polygon at most and makes two of it.
  static constexpr std::size_t MAX_CORNERS = 3 + ConvexRegion::MAX_PLANES;

  explicit ClippedTriangle(const float* corners);

  /// Keeps what is in front of the plane, which belongs to it.
  void cut(const Plane& plane);

  /// The same for those planes whose bits are set.
  void cut(const std::vector<Plane>& planes, std::uint32_t which)
  {
    for (std::size_t i = 0; i < planes.size(); ++i) {
      if ((which >> i & 1u) != 0) {
        cut(planes[i]);
      }
    }
  }

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  const Vector3& operator[](std::size_t index) const { return points_[index]; }

  /// The mean of the corners: a point of it.
  Vector3 center() const;

 private:
  std::size_t size_ = 3;
  std::array<Vector3, MAX_CORNERS> points_;
  Vector3 largest_;  // size of the coordinates, which cuts round relative to
};

/// How a triangle lies to planes without cutting it: bit i of `outside` and of `cutting` says that
/// plane i has all corners, or some but not all, behind it.
struct PlaneSides
{
  std::uint32_t outside = 0, cutting = 0;
};
PlaneSides planeSides(const std::vector<Plane>& planes, std::uint32_t which, const float* corners);

}  // namespace mesh_map
