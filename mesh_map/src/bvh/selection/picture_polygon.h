#pragma once

#include <mesh_map/bvh/selection/region.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bvh/selection/region_clip.h"

namespace mesh_map {

/// > 0 where c is to the left of the way from a to b.
inline double turn(const Vector2& a, const Vector2& b, const Vector2& c)
{
  return cross(b - a, c - a);
}

struct Rectangle
{
  Vector2 lower, upper;
};

inline bool overlap(const Rectangle& a, const Rectangle& b)
{
  return a.lower[0] <= b.upper[0] && b.lower[0] <= a.upper[0] && a.lower[1] <= b.upper[1] &&
         b.lower[1] <= a.upper[1];
}

/// Around one point or more.
inline Rectangle boundsOf(const Vector2* points, std::size_t count)
{
  Rectangle bounds{points[0], points[0]};
  for (std::size_t i = 1; i < count; ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      bounds.lower[axis] = std::min(bounds.lower[axis], points[i][axis]);
      bounds.upper[axis] = std::max(bounds.upper[axis], points[i][axis]);
    }
  }
  return bounds;
}

inline Rectangle boundsOf(const Vector2& a, const Vector2& b)
{
  return {{std::min(a[0], b[0]), std::min(a[1], b[1])},
          {std::max(a[0], b[0]), std::max(a[1], b[1])}};
}

/// A convex polygon of the plane, counterclockwise; or a segment or point, with any corners.
struct ConvexPolygon
{
  std::size_t size = 0;
  std::array<Vector2, ClippedTriangle::MAX_CORNERS> corners;

  const Vector2& operator[](std::size_t index) const { return corners[index]; }
  const Vector2& after(std::size_t index) const
  {
    return corners[index + 1 < size ? index + 1 : 0];
  }
  Vector2 center() const;
  Rectangle bounds() const { return boundsOf(corners.data(), size); }
  bool contains(const Vector2& point) const;
};

/// How a segment meets a convex polygon: INSIDE = runs through its interior. Convex shapes without
/// a common point are separated by a line along a side of one of them (or, for segments of one
/// line, by an axis). Shapes are compared along with all their corners, so that a side that is
/// nothing but rounding, and points anywhere, does no harm.
Side meet(const Vector2& from, const Vector2& to, const ConvexPolygon& convex);

/// A polygon of the plane by the even-odd rule, with its edges, over a grid that answers for most
/// points and rectangles without looking at edges.
class PicturePolygon
{
 public:
  /// Three corners or more, of at most 1e30.
  explicit PicturePolygon(const std::vector<Vector2>& corners);

  const Rectangle& bounds() const { return bounds_; }
  bool contains(const Vector2& point) const;

  /// OUTSIDE and INSIDE: sure for convex() of every part of the rectangle; else TOUCHING.
  Side rectangle(const Rectangle& rectangle) const;

  /// How a convex polygon lies to this one. INSIDE: no edge of this one runs through it.
  Side convex(const ConvexPolygon& convex) const;

  /// A point of both, which touch, up to rounding.
  Vector2 common(const ConvexPolygon& convex) const;

 private:
  struct Edge
  {
    Vector2 from, to;
    std::size_t first_row, last_row;
  };
  static constexpr std::size_t CELLS = 64;  // along each side of the grid

  std::size_t cell(std::size_t axis, double coordinate) const;
  Side rectangleByCells(const Rectangle& rectangle) const;
  bool containsByEdges(const Vector2& point) const;
  void markCells(const Edge& edge);
  void fillCells();

  /// Calls visit(edge) for the edges that may reach into the rows of a rectangle, until it is true.
  template <class Visit>
  bool anyEdge(const Rectangle& rectangle, const Visit& visit) const;

  Rectangle bounds_;
  Vector2 cells_per_unit_;
  std::vector<Edge> edges_;

  // Row i of the grid has the edges row_edges_[row_starts_[i]] to row_edges_[row_starts_[i+1] - 1].
  std::vector<std::uint32_t> row_starts_, row_edges_;

  std::vector<std::uint8_t> passed_;          // per cell: whether an edge may pass through it
  std::vector<std::uint8_t> inside_;          // per cell that none passes: whether it is inside
  std::vector<std::uint32_t> passed_before_;  // passed cells left of and below a corner of the grid
};

}  // namespace mesh_map
