#include "bvh/selection/region_clip.h"

#include <algorithm>

namespace mesh_map {

ClippedTriangle::ClippedTriangle(const float* corners)
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    largest_[axis] = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      points_[k][axis] = corners[3 * k + axis];
      largest_[axis] = std::max(largest_[axis], std::abs(points_[k][axis]));
    }
  }
}

void ClippedTriangle::cut(const Plane& plane)
{
  // Points that cuts have made are wrong by some roundings of the coordinates of the triangle.
  const double slack = 4.0 * HEIGHT_ROUNDING * heightTerms(plane, largest_);
  std::array<double, MAX_CORNERS> heights;
  bool any_behind = false;
  for (std::size_t i = 0; i < size_; ++i) {
    heights[i] = height(plane, points_[i][0], points_[i][1], points_[i][2]);
    // A rounding behind the plane is on it.
    heights[i] = heights[i] < 0.0 && heights[i] >= -slack ? 0.0 : heights[i];
    any_behind = any_behind || heights[i] < 0.0;
  }
  if (!any_behind) {
    return;
  }
  const std::array<Vector3, MAX_CORNERS> before = points_;
  const std::size_t count = size_;
  size_ = 0;
  const auto add = [this](const Vector3& point) {
    if (size_ < MAX_CORNERS) {  // more corners are made by rounding alone, and lie at others
      points_[size_++] = point;
    }
  };
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = i + 1 < count ? i + 1 : 0;
    const double here = heights[i], there = heights[next];
    if (here >= 0.0) {
      add(before[i]);
    }
    if ((here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0)) {
      const double t = here / (here - there);
      add(before[i] + t * (before[next] - before[i]));
    }
  }
}

Vector3 ClippedTriangle::center() const
{
  Vector3 sum{};
  for (std::size_t i = 0; i < size_; ++i) {
    sum = sum + points_[i] / static_cast<double>(size_);
  }
  return sum;
}

PlaneSides planeSides(const std::vector<Plane>& planes, std::uint32_t which, const float* corners)
{
  PlaneSides sides;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if ((which >> i & 1u) == 0) {
      continue;
    }
    unsigned behind = 0;
    for (std::size_t k = 0; k < 9; k += 3) {
      behind += height(planes[i], corners[k], corners[k + 1], corners[k + 2]) < 0.0 ? 1 : 0;
    }
    sides.outside |= behind == 3 ? 1u << i : 0u;
    sides.cutting |= behind == 1 || behind == 2 ? 1u << i : 0u;
    if (behind == 3) {
      break;
    }
  }
  return sides;
}

}  // namespace mesh_map
