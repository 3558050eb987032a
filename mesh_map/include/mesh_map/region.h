#ifndef MESH_MAP_REGION_H
#define MESH_MAP_REGION_H

#include <mesh_map/array_view.h>

#include <array>
#include <cstddef>
#include <vector>

namespace mesh_map {

/// How a box or triangle lies to a region.
enum class Side
{
  OUTSIDE,
  TOUCHING,  ///< for boxes: perhaps
  INSIDE
};

/// A box in the coordinates of the mesh.
struct Box
{
  std::array<double, 3> lower, upper;
};

/// A closed part of space. What it says about a triangle is exact in double precision; what it says
/// about a box is safe: OUTSIDE and INSIDE are sure for every triangle in the box, also where
/// triangle() rounds.
class Region
{
 public:
  virtual ~Region() = default;
  virtual Side box(const Box& box) const = 0;

  /// OUTSIDE, TOUCHING (a point of it is in the region, the border of which belongs to it) or
  /// INSIDE (all of it). 9 floats.
  virtual Side triangle(const float* corners) const = 0;

  /// Whether a point is in the region.
  virtual bool contains(const std::array<double, 3>& point) const = 0;

  /// A point of a touching triangle that is in the region (up to rounding).
  virtual std::array<double, 3> witness(const float* corners) const = 0;
};

/// A ball. A center or radius that is not finite, or a negative radius, contains nothing.
class SphereRegion : public Region
{
 public:
  SphereRegion(const std::array<double, 3>& center, double radius);
  Side box(const Box& box) const override;
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
class ConvexRegion : public Region
{
 public:
  static constexpr std::size_t MAX_PLANES = 16;

  /// Throws std::invalid_argument for no planes or too many.
  explicit ConvexRegion(const std::vector<Plane>& planes);

  /// A box: its axes are unit vectors at right angles (not checked here).
  static ConvexRegion box(const std::array<double, 3>& center,
                          const std::array<std::array<double, 3>, 3>& axes,
                          const std::array<double, 3>& half_size);

  Side box(const Box& box) const override;
  Side triangle(const float* corners) const override;
  bool contains(const std::array<double, 3>& point) const override;
  std::array<double, 3> witness(const float* corners) const override;

  const std::vector<Plane>& planes() const { return planes_; }

 private:
  std::vector<Plane> planes_;
};

/// What a camera sees within a polygon of its picture (even-odd rule), between its near and its far
/// plane. Corners are in normalized device coordinates (-1 to 1, x to the right, y up); the matrix
/// (row-major, column vectors) takes points of the mesh to clip space as OpenGL has it
/// (-w <= z <= w). A corner or entry that is not finite, or fewer than three corners, contains
/// nothing.
class LassoRegion : public Region
{
 public:
  using Point = std::array<double, 2>;

  LassoRegion(std::vector<Point> polygon, const std::array<double, 16>& view_projection);
  Side box(const Box& box) const override;
  Side triangle(const float* corners) const override;
  bool contains(const std::array<double, 3>& point) const override;
  std::array<double, 3> witness(const float* corners) const override;

  const std::vector<Point>& polygon() const { return polygon_; }
  const std::array<double, 16>& viewProjection() const { return view_projection_; }

 private:
  std::vector<Point> polygon_;
  std::array<double, 16> view_projection_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_REGION_H
