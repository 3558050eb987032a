#ifndef MESH_MAP_SRC_CONVEX_POLYGON_H
#define MESH_MAP_SRC_CONVEX_POLYGON_H

#include <mesh_map/region.h>

#include "region_clip.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace mesh_map {

using Point2 = std::array<double, 2>;

/// > 0 where c is to the left of the way from a to b.
inline double turn(const Point2& a, const Point2& b, const Point2& c)
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

struct Rectangle
{
  Point2 lower, upper;
};

inline bool overlap(const Rectangle& a, const Rectangle& b)
{
  return a.lower[0] <= b.upper[0] && b.lower[0] <= a.upper[0] && a.lower[1] <= b.upper[1] &&
         b.lower[1] <= a.upper[1];
}

inline Rectangle boundsOf(const Point2& a, const Point2& b)
{
  return {{std::min(a[0], b[0]), std::min(a[1], b[1])},
          {std::max(a[0], b[0]), std::max(a[1], b[1])}};
}

/// A convex polygon of the plane, counterclockwise; or a segment or point, with any corners.
struct ConvexPolygon
{
  std::size_t size = 0;
  std::array<Point2, ClippedTriangle::MAX_CORNERS> corners;

  const Point2& operator[](std::size_t index) const { return corners[index]; }
  const Point2& after(std::size_t index) const { return corners[index + 1 < size ? index + 1 : 0]; }
  Point2 center() const;
  Rectangle bounds() const;
  bool contains(const Point2& point) const;
};

/// How a segment meets a convex polygon: INSIDE = runs through its interior. Convex shapes without
/// a common point are separated by a line along a side of one of them (or, for segments of one
/// line, by an axis). Shapes are compared along with all their corners, so that a side that is
/// nothing but rounding, and points anywhere, does no harm.
Side meet(const Point2& from, const Point2& to, const ConvexPolygon& convex);

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_CONVEX_POLYGON_H
