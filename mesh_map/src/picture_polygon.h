#ifndef MESH_MAP_SRC_PICTURE_POLYGON_H
#define MESH_MAP_SRC_PICTURE_POLYGON_H

#include <mesh_map/region.h>

#include "convex_polygon.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// A polygon of the plane by the even-odd rule, with its edges, over a grid that answers for most
/// points and rectangles without looking at edges.
class PicturePolygon
{
 public:
  /// Three corners or more, of at most 1e30.
  explicit PicturePolygon(const std::vector<Point2>& corners);

  const Rectangle& bounds() const { return bounds_; }
  bool contains(const Point2& point) const;

  /// OUTSIDE and INSIDE: sure for convex() of every part of the rectangle; else TOUCHING.
  Side rectangle(const Rectangle& rectangle) const;

  /// How a convex polygon lies to this one. INSIDE: no edge of this one runs through it.
  Side convex(const ConvexPolygon& convex) const;

  /// A point of both, which touch, up to rounding.
  Point2 common(const ConvexPolygon& convex) const;

 private:
  struct Edge
  {
    Point2 from, to;
    std::size_t first_row, last_row;
  };
  static constexpr std::size_t CELLS = 64;  // along each side of the grid

  std::size_t cell(std::size_t axis, double coordinate) const;
  Side rectangleByCells(const Rectangle& rectangle) const;
  bool containsByEdges(const Point2& point) const;
  void markCells(const Edge& edge);
  void fillCells();

  /// Calls visit(edge) for the edges that may reach into the rows of a rectangle, until it is true.
  template <class Visit>
  bool anyEdge(const Rectangle& rectangle, const Visit& visit) const;

  Rectangle bounds_;
  Point2 cells_per_unit_;
  std::vector<Edge> edges_;

  // Row i of the grid has the edges row_edges_[row_starts_[i]] to row_edges_[row_starts_[i+1] - 1].
  std::vector<std::uint32_t> row_starts_, row_edges_;

  std::vector<std::uint8_t> passed_;          // per cell: whether an edge may pass through it
  std::vector<std::uint8_t> inside_;          // per cell that none passes: whether it is inside
  std::vector<std::uint32_t> passed_before_;  // passed cells left of and below a corner of the grid
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_PICTURE_POLYGON_H
