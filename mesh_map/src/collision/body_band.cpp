#include "collision/body_band.h"

#include <limits>

namespace mesh_map {

namespace {

/// Whether all corners of a triangle are on one side of an interval along an axis.
bool isBeyond(const float* triangle, std::size_t axis, double lower, double upper)
{
  const float a = triangle[axis], b = triangle[axis + 3], c = triangle[axis + 6];
  return std::max({a, b, c}) < lower || std::min({a, b, c}) > upper;
}

/// How far the square of the distance of a point from the origin is, at the least, on a segment.
double squaredDistance(const Vector2& from, const Vector2& to)
{
  const Vector2 side = to - from;
  const double length = dot(side, side);
  const double share = length > 0.0 ? std::min(1.0, std::max(0.0, -dot(from, side) / length)) : 0.0;
  const Vector2 nearest = from + share * side;
  return dot(nearest, nearest);
}

}  // namespace

Plane FaceBand::upright(const Vector2& normal, const Vector3& through, double slack)
{
  const double length = norm(normal);
  const Vector2 unit = normal / length;
  return {unit[0], unit[1], 0.0, slack - unit[0] * through[0] - unit[1] * through[1]};
}

FaceBand::FaceBand(const MeshView& mesh, std::size_t face, const BodyHeights& heights, double slack)
    : heights_(heights), slack_(slack)
{
  const std::array<Vector3, 3> corners = {
      pointOf(mesh.corner(face, 0)), pointOf(mesh.corner(face, 1)), pointOf(mesh.corner(face, 2))};
  const Vector3 n =
      triangleNormal(mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2));
  const double length = norm(n);
  if (!(length > 0.0) || !(std::abs(n[2]) >= LEAST_LEVEL * length)) {
    return;
  }
  valid_ = true;
  origin_ = corners[0];
  slope_ = {-n[0] / n[2], -n[1] / n[2]};
  const double turn = n[2] > 0.0 ? 1.0 : -1.0;
  const double level = origin_[2] - slope_[0] * origin_[0] - slope_[1] * origin_[1];
  low_ = {-slope_[0], -slope_[1], 1.0, -level - heights.low};
  high_ = {slope_[0], slope_[1], -1.0, level + heights.high};
  lower_ = upper_ = corners[0];
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 &here = corners[k], &next = corners[(k + 1) % 3];
    const Vector3 side = next - here;
    sides_[k] = upright({-turn * side[1], turn * side[0]}, here, slack);
    // A point of the plane d beyond `here` in plan is nearer to it than to `next` as long as
    // side . (d, slope . d) < side . side / 2.
    const Vector2 along = {side[0] + side[2] * slope_[0], side[1] + side[2] * slope_[1]};
    bisectors_[k] = upright(-along, here + 0.5 * side, slack);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower_[axis] = std::min(lower_[axis], here[axis]);
      upper_[axis] = std::max(upper_[axis], here[axis]);
    }
  }
  const double rise = slack * norm(slope_);
  lower_ = lower_ + Vector3{-slack, -slack, heights.low - rise};
  upper_ = upper_ + Vector3{slack, slack, heights.high + rise};
}

unsigned FaceBand::cornersBelow(const float* triangle, unsigned wanted) const
{
  if (isBeyond(triangle, 0, lower_[0], upper_[0]) || isBeyond(triangle, 1, lower_[1], upper_[1]) ||
      isBeyond(triangle, 2, lower_[2], upper_[2])) {
    return 0;
  }
  const double a = heightOf(triangle), b = heightOf(triangle + 3), c = heightOf(triangle + 6);
  if (std::max({a, b, c}) <= heights_.low || std::min({a, b, c}) >= heights_.high) {
    return 0;
  }
  ClippedTriangle rest(triangle);
  for (std::size_t k = 0; k < 3; ++k) {
    rest.cut(sides_[k]);
  }
  rest.cut(low_);
  rest.cut(high_);
  unsigned found = 0;
  for (unsigned k = 0; k < 3 && !rest.empty(); ++k) {
    if ((wanted >> k & 1u) != 0) {
      ClippedTriangle part = rest;
      part.cut(bisectors_[k]);
      const Plane& before = bisectors_[(k + 2) % 3];
      // Behind it, but for the slack, which is on both sides.
      part.cut({-before[0], -before[1], 0.0, 2.0 * slack_ - before[3]});
      found |= part.empty() ? 0u : 1u << k;
    }
  }
  return found;
}

bool VertexBand::isNear(const ClippedTriangle& polygon) const
{
  double least = std::numeric_limits<double>::infinity();
  bool left = false, right = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 here = polygon[i] - foot_,
                  next = polygon[i + 1 < polygon.size() ? i + 1 : 0] - foot_;
    const Vector2 from = {here[0], here[1]}, to = {next[0], next[1]};
    least = std::min(least, squaredDistance(from, to));
    const double side = cross(from, to);
    left = left || side > 0.0;
    right = right || side < 0.0;
  }
  return least <= radius_ * radius_ || (left != right && polygon.size() > 2);
}

bool VertexBand::isNear(const float* triangle) const
{
  return isNear(ClippedTriangle(triangle));
}

bool VertexBand::meets(const float* triangle) const
{
  const Vector3 low = lower(), high = upper();
  if (isBeyond(triangle, 0, low[0], high[0]) || isBeyond(triangle, 1, low[1], high[1])) {
    return false;
  }
  const double a = triangle[2], b = triangle[5], c = triangle[8];
  if (std::max({a, b, c}) <= low[2] || std::min({a, b, c}) >= high[2]) {
    return false;
  }
  for (std::size_t k = 0; k < 9; k += 3) {
    if (triangle[k + 2] > low[2] && triangle[k + 2] < high[2] && isWithin(triangle + k)) {
      return true;  // cuts would keep this corner
    }
  }
  ClippedTriangle rest(triangle);
  rest.cut({0.0, 0.0, 1.0, -low[2]});
  rest.cut({0.0, 0.0, -1.0, high[2]});
  return isNear(rest);
}

}  // namespace mesh_map
