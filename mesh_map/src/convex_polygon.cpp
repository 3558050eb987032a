#include "convex_polygon.h"

namespace mesh_map {

Point2 ConvexPolygon::center() const
{
  Point2 sum{};
  for (std::size_t i = 0; i < size; ++i) {
    sum[0] += corners[i][0] / static_cast<double>(size);
    sum[1] += corners[i][1] / static_cast<double>(size);
  }
  return sum;
}

Rectangle ConvexPolygon::bounds() const
{
  Rectangle bounds{corners[0], corners[0]};
  for (std::size_t i = 1; i < size; ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      bounds.lower[axis] = std::min(bounds.lower[axis], corners[i][axis]);
      bounds.upper[axis] = std::max(bounds.upper[axis], corners[i][axis]);
    }
  }
  return bounds;
}

bool ConvexPolygon::contains(const Point2& point) const
{
  const Rectangle box = bounds();
  bool inside = overlap(box, {point, point});
  for (std::size_t i = 0; i < size; ++i) {
    inside = inside && turn(corners[i], after(i), point) >= 0.0;
  }
  return inside;
}

Side meet(const Point2& from, const Point2& to, const ConvexPolygon& convex)
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
    const Point2 &here = convex[i], &next = convex.after(i);
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

}  // namespace mesh_map
