#include "bvh/selection/picture_polygon.h"

#include <algorithm>
#include <cmath>

#include "base/rows.h"

namespace mesh_map {

Vector2 ConvexPolygon::center() const
{
  Vector2 sum{};
  for (std::size_t i = 0; i < size; ++i) {
    sum = sum + corners[i] / static_cast<double>(size);
  }
  return sum;
}

bool ConvexPolygon::contains(const Vector2& point) const
{
  const Rectangle box = bounds();
  bool inside = overlap(box, {point, point});
  for (std::size_t i = 0; i < size; ++i) {
    inside = inside && turn(corners[i], after(i), point) >= 0.0;
  }
  return inside;
}

Side meet(const Vector2& from, const Vector2& to, const ConvexPolygon& convex)
{
  bool through = true;
  std::size_t left = 0, right = 0;
  for (std::size_t i = 0; i < convex.size; ++i) {
    const double side = turn(from, to, convex[i]);
    left += side > 0.0 ? 1 : 0;
    right += side < 0.0 ? 1 : 0;
  }
  if (left == convex.size || right == convex.size) {
    return Side::OUTSIDE;
  }
  for (std::size_t i = 0; i < convex.size; ++i) {
    const Vector2 &here = convex[i], &next = convex.after(i);
    double low = 0.0, high = 0.0;
    for (std::size_t k = 0; k < convex.size; ++k) {
      const double side = k == i ? 0.0 : turn(here, next, convex[k]);
      low = std::min(low, side);
      high = std::max(high, side);
    }
    const double a = turn(here, next, from), b = turn(here, next, to);
    if ((a < low && b < low) || (a > high && b > high)) {
      return Side::OUTSIDE;
    }
    through = through && ((std::max(a, b) > low && std::min(a, b) < high) || here == next);
  }
  return through && left > 0 && right > 0 ? Side::INSIDE : Side::TOUCHING;
}

PicturePolygon::PicturePolygon(const std::vector<Vector2>& corners)
    : bounds_(boundsOf(corners.data(), corners.size()))
{
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double size = bounds_.upper[axis] - bounds_.lower[axis];
    const double largest = std::max(std::abs(bounds_.lower[axis]), std::abs(bounds_.upper[axis]));
    // One cell where cells would be so small that rounding counts.
    cells_per_unit_[axis] = size > 1e-6 * largest && size > 1e-200 ? CELLS / size : 0.0;
  }
  passed_.assign(CELLS * CELLS, 0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2 &from = corners[i], &to = corners[i + 1 < corners.size() ? i + 1 : 0];
    edges_.push_back(
        {from, to, cell(1, std::min(from[1], to[1])), cell(1, std::max(from[1], to[1]))});
    markCells(edges_.back());
  }
  row_starts_ = fillRows(CELLS, row_edges_, [this](const auto& put) {
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      for (std::size_t row = edges_[i].first_row; row <= edges_[i].last_row; ++row) {
        put(row, static_cast<std::uint32_t>(i));
      }
    }
  });
  fillCells();
}

std::size_t PicturePolygon::cell(std::size_t axis, double coordinate) const
{
  const double place = (coordinate - bounds_.lower[axis]) * cells_per_unit_[axis];
  return place > 0.0 ? std::min(CELLS - 1, static_cast<std::size_t>(std::min(place, 1e3))) : 0;
}

template <class Visit>
bool PicturePolygon::anyEdge(const Rectangle& rectangle, const Visit& visit) const
{
  const std::size_t first = cell(1, rectangle.lower[1]), last = cell(1, rectangle.upper[1]);
  for (std::size_t row = first; row <= last; ++row) {
    for (std::uint32_t i = row_starts_[row]; i < row_starts_[row + 1]; ++i) {
      const Edge& edge = edges_[row_edges_[i]];
      if (std::max(edge.first_row, first) == row && visit(edge)) {  // once, in its first row here
        return true;
      }
    }
  }
  return false;
}

/// Marks the cells through which the edge may go, by rows, a millionth of a cell wider than it is.
void PicturePolygon::markCells(const Edge& edge)
{
  constexpr double margin = 1e-6;
  const double x = edge.from[0], y = edge.from[1];
  const double dx = edge.to[0] - x, dy = edge.to[1] - y;
  for (std::size_t row = edge.first_row; row <= edge.last_row; ++row) {
    double first = 0.0, last = 1.0;  // of the edge, the part in this row
    if (dy != 0.0 && cells_per_unit_[1] > 0.0) {
      const double low =
          bounds_.lower[1] + (static_cast<double>(row) - margin) / cells_per_unit_[1];
      const double high = low + (1.0 + 2.0 * margin) / cells_per_unit_[1];
      const double at_low = (low - y) / dy, at_high = (high - y) / dy;
      first = std::min(1.0, std::max(0.0, std::min(at_low, at_high)));
      last = std::max(0.0, std::min(1.0, std::max(at_low, at_high)));
    }
    const double x0 = x + first * dx, x1 = x + last * dx;
    const double wider = cells_per_unit_[0] > 0.0 ? margin / cells_per_unit_[0] : 0.0;
    const std::size_t end = cell(0, std::max(x0, x1) + wider);
    for (std::size_t column = cell(0, std::min(x0, x1) - wider); column <= end; ++column) {
      passed_[row * CELLS + column] = 1;
    }
  }
}

void PicturePolygon::fillCells()
{
  constexpr std::size_t corners = CELLS + 1;
  inside_.assign(CELLS * CELLS, 0);
  passed_before_.assign(corners * corners, 0);
  for (std::size_t row = 0; row < CELLS; ++row) {
    for (std::size_t column = 0; column < CELLS; ++column) {
      const std::size_t here = row * CELLS + column, corner = row * corners + column;
      passed_before_[corner + corners + 1] = passed_[here] + passed_before_[corner + corners] +
                                             passed_before_[corner + 1] - passed_before_[corner];
      if (passed_[here] != 0 || cells_per_unit_[0] == 0.0 || cells_per_unit_[1] == 0.0) {
        continue;
      }
      // Beside a cell that no edge passes, there is the same.
      inside_[here] =
          column > 0 && passed_[here - 1] == 0
              ? inside_[here - 1]
              : containsByEdges(
                    {bounds_.lower[0] + (static_cast<double>(column) + 0.5) / cells_per_unit_[0],
                     bounds_.lower[1] + (static_cast<double>(row) + 0.5) / cells_per_unit_[1]});
    }
  }
}

bool PicturePolygon::containsByEdges(const Vector2& point) const
{
  bool odd = false;  // number of edges to the right (M. Shimrat: Algorithm 112, 1962)
  const bool on_edge = anyEdge({point, point}, [&](const Edge& edge) {
    const double side = turn(edge.from, edge.to, point);
    const bool rises = edge.to[1] > edge.from[1];
    if ((edge.from[1] > point[1]) != (edge.to[1] > point[1]) && (side > 0.0) == rises) {
      odd = !odd;
    }
    return side == 0.0 && overlap(boundsOf(edge.from, edge.to), {point, point});
  });
  return on_edge || odd;
}

bool PicturePolygon::contains(const Vector2& point) const
{
  const Side side = rectangleByCells({point, point});
  return side == Side::TOUCHING ? containsByEdges(point) : side == Side::INSIDE;
}

Side PicturePolygon::rectangleByCells(const Rectangle& rectangle) const
{
  if (!overlap(rectangle, bounds_)) {
    return Side::OUTSIDE;
  }
  const std::size_t left = cell(0, rectangle.lower[0]), right = cell(0, rectangle.upper[0]) + 1;
  const std::size_t below = cell(1, rectangle.lower[1]), above = cell(1, rectangle.upper[1]) + 1;
  constexpr std::size_t corners = CELLS + 1;
  const std::uint32_t passed =
      passed_before_[above * corners + right] - passed_before_[above * corners + left] -
      passed_before_[below * corners + right] + passed_before_[below * corners + left];
  if (passed != 0) {
    return Side::TOUCHING;
  }
  if (inside_[below * CELLS + left] == 0) {
    return Side::OUTSIDE;
  }
  // What reaches beyond the grid reaches beyond the polygon: such cells are passed, if rounding
  // does not say otherwise.
  const bool within =
      rectangle.lower[0] >= bounds_.lower[0] && rectangle.upper[0] <= bounds_.upper[0] &&
      rectangle.lower[1] >= bounds_.lower[1] && rectangle.upper[1] <= bounds_.upper[1];
  return within ? Side::INSIDE : Side::TOUCHING;
}

Side PicturePolygon::rectangle(const Rectangle& rectangle) const
{
  const Side sure = rectangleByCells(rectangle);
  if (sure != Side::TOUCHING) {
    return sure;
  }
  // Wider by far more than what meet() rounds.
  const double margin =
      1e-12 * (bounds_.upper[0] - bounds_.lower[0] + bounds_.upper[1] - bounds_.lower[1]);
  const Rectangle wider{{rectangle.lower[0] - margin, rectangle.lower[1] - margin},
                        {rectangle.upper[0] + margin, rectangle.upper[1] + margin}};
  const ConvexPolygon shape{4,
                            {wider.lower,
                             {wider.upper[0], wider.lower[1]},
                             wider.upper,
                             {wider.lower[0], wider.upper[1]}}};
  const bool met = anyEdge(wider, [&](const Edge& edge) {
    return overlap(boundsOf(edge.from, edge.to), wider) &&
           meet(edge.from, edge.to, shape) != Side::OUTSIDE;
  });
  if (met) {
    return Side::TOUCHING;
  }
  return contains(shape.center()) ? Side::INSIDE : Side::OUTSIDE;
}

Side PicturePolygon::convex(const ConvexPolygon& convex) const
{
  const Rectangle box = convex.bounds();
  const Side sure = rectangleByCells(box);
  if (sure != Side::TOUCHING) {
    return sure;
  }
  bool touched = false;
  const bool crossed = anyEdge(box, [&](const Edge& edge) {
    if (!overlap(boundsOf(edge.from, edge.to), box)) {
      return false;
    }
    const Side side = meet(edge.from, edge.to, convex);
    touched = touched || side != Side::OUTSIDE;
    return side == Side::INSIDE;
  });
  if (crossed) {
    return Side::TOUCHING;
  }
  std::size_t contained = 0;
  for (std::size_t i = 0; i < convex.size; ++i) {
    contained += contains(convex[i]) ? 1 : 0;
  }
  if (contained == convex.size && contains(convex.center())) {
    return Side::INSIDE;
  }
  return touched || contained > 0 ? Side::TOUCHING : Side::OUTSIDE;
}

Vector2 PicturePolygon::common(const ConvexPolygon& convex) const
{
  Vector2 found = convex.center();
  if (contains(found)) {
    return found;
  }
  for (std::size_t i = 0; i < convex.size; ++i) {
    if (contains(convex[i])) {
      return convex[i];
    }
  }
  for (const Edge& edge : edges_) {
    if (convex.contains(edge.from)) {
      return edge.from;
    }
  }
  anyEdge(convex.bounds(), [&](const Edge& edge) {
    for (std::size_t i = 0; i < convex.size; ++i) {
      const double a = turn(edge.from, edge.to, convex[i]);
      const double b = turn(edge.from, edge.to, convex.after(i));
      const double c = turn(convex[i], convex.after(i), edge.from);
      const double d = turn(convex[i], convex.after(i), edge.to);
      if ((a > 0.0) != (b > 0.0) && (c > 0.0) != (d > 0.0)) {
        const double t = a / (a - b);
        found = convex[i] + t * (convex.after(i) - convex[i]);
        return true;
      }
    }
    return false;
  });
  return found;
}

}  // namespace mesh_map
