#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace mesh_map {

/// How a triangle lies to a region, or a box: then TOUCHING is perhaps, the others are sure for
/// every triangle in the box.
enum class Side
{
  OUTSIDE,
  TOUCHING,
  INSIDE
};

/// A box in the coordinates of the mesh.
struct Box
{
  std::array<double, 3> lower, upper;
};

/// A closed part of space: a SphereRegion, a ConvexRegion or a LassoRegion. What it says about a
/// triangle is computed in double precision.
class Region
{
 public:
  virtual ~Region() = default;

  /// Whether it may contain anything at all.
  bool valid() const { return valid_; }

  /// OUTSIDE, TOUCHING (a point of it is in the region, the border of which belongs to it) or
  /// INSIDE (all of it: each corner is contained). 9 floats. One without area is the point or
  /// segment that it is. It touches wherever a corner is contained.
  virtual Side triangle(const float* corners) const = 0;

  /// Whether a point is in the region.
  virtual bool contains(const std::array<double, 3>& point) const = 0;

  /// A point of a touching triangle that is in the region (up to rounding).
  virtual std::array<double, 3> witness(const float* corners) const = 0;

 protected:
  bool valid_ = true;
};

/// A ball. A center or radius that is not finite, or a negative radius, contains nothing.
///
/// A triangle touches it if a corner or closestPointOnTriangle() is within the radius.
class SphereRegion final : public Region
{
 public:
  SphereRegion(const std::array<double, 3>& center, double radius);
  Side triangle(const float* corners) const override;
  bool contains(const std::array<double, 3>& point) const override;
  std::array<double, 3> witness(const float* corners) const override;

  const std::array<double, 3>& center() const { return center_; }
  double radius() const { return radius_; }

 private:
  std::array<double, 3> center_;
  double radius_;
};

/// a x + b y + c z + d >= 0
using Plane = std::array<double, 4>;

/// Where all planes are >= 0: a frustum or a box. Planes are scaled to a normal of length 1. One
/// that is not finite or has no normal makes the region contain nothing.
///
/// A triangle touches it if anything is left of it when the planes have cut it. A cut that passes
/// another plane by less than 1e-14 of the size of the numbers in play still counts as in it, so
/// that a touch in one point is not lost to rounding (unless an edge runs nearly along a plane
/// there).
class ConvexRegion final : public Region
{
 public:
  static constexpr std::size_t MAX_PLANES = 16;

  /// Throws std::invalid_argument for no planes or too many.
  explicit ConvexRegion(const std::vector<Plane>& planes);

  /// A box: its axes are unit vectors at right angles (not checked here). One with a negative size
  /// contains nothing.
  static ConvexRegion box(const std::array<double, 3>& center,
                          const std::array<std::array<double, 3>, 3>& axes,
                          const std::array<double, 3>& half_size);

  Side triangle(const float* corners) const override;
  bool contains(const std::array<double, 3>& point) const override;
  std::array<double, 3> witness(const float* corners) const override;

  const std::vector<Plane>& planes() const { return planes_; }

  /// triangle(), where bit i of `cutting` is 0 if plane i is known to contain all corners.
  Side triangle(const float* corners, std::uint32_t cutting) const;

 private:
  std::vector<Plane> planes_;
};

class PicturePolygon;

/// What a camera sees within a polygon of its picture (even-odd rule; its edges belong to it),
/// between its near and its far plane. Corners are in normalized device coordinates (-1 to 1, x to
/// the right, y up; those beyond the picture are as good); the matrix (row-major, column vectors)
/// takes points of the mesh to clip space as OpenGL has it (-w <= z <= w). A corner or entry that
/// is not finite, a corner beyond 1e30, or fewer than three corners, contains nothing.
///
/// A triangle is cut by the near and the far plane and the bounds of the polygon as by a
/// ConvexRegion, and what is left is projected. It is INSIDE if nothing was cut and no edge of the
/// polygon runs through it.
class LassoRegion final : public Region
{
 public:
  using Point = std::array<double, 2>;

  LassoRegion(std::vector<Point> polygon, const std::array<double, 16>& view_projection);
  Side triangle(const float* corners) const override;
  bool contains(const std::array<double, 3>& point) const override;
  std::array<double, 3> witness(const float* corners) const override;

  const std::vector<Point>& polygon() const { return polygon_; }
  const std::array<double, 16>& viewProjection() const { return view_projection_; }

  /// Whether a point of the picture is in the polygon.
  bool polygonContains(const Point& point) const;

  /// The planes around it.
  const ConvexRegion& frustum() const { return frustum_; }

  /// Of a box that `in_frustum` tells is in the frustum, or of one that touches it.
  Side boxInFrustum(const Box& box, bool in_frustum) const;

  /// triangle(), where bit i of `cutting` is 0 if plane i of the frustum is known to contain all
  /// corners.
  Side triangle(const float* corners, std::uint32_t cutting) const;

 private:
  std::vector<Point> polygon_;
  std::array<double, 16> view_projection_;
  std::array<double, 16> matrix_;                  // scaled to entries of at most 1
  ConvexRegion frustum_;                           // around the polygon, near to far
  std::shared_ptr<const PicturePolygon> picture_;  // none where invalid
};

}  // namespace mesh_map
