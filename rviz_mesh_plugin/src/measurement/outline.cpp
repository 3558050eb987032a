#include "measurement/outline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

namespace rviz_mesh_plugin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// So far beside an outline faces are looked at, in meters: points on walls are rounded.
constexpr double BESIDE = 1e-3;

double cross(const Vector2d& a, const Vector2d& b)
{
  return a[0] * b[1] - a[1] * b[0];
}

/// To the left of the line from a to b; of each point not on it exactly one of this and the line
/// from b to a is true, and of those on it, too.
double leftOf(const Vector2d& a, const Vector2d& b, const Vector2d& point)
{
  const bool forward = a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
  return forward ? cross(b - a, point - a) : -cross(a - b, point - b);
}

bool isLeft(const Vector2d& a, const Vector2d& b, double left)
{
  const bool forward = a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
  return forward ? left >= 0.0 : left > 0.0;
}

using Polygon = std::vector<Vector3d>;

/// What of it is to the left of a line in its first two coordinates (Sutherland and Hodgman, 1974).
void clip(Polygon& polygon, const Vector2d& a, const Vector2d& b)
{
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& one = polygon[i];
    const Vector3d& next = polygon[(i + 1) % polygon.size()];
    const double d = leftOf(a, b, one.head<2>()), e = leftOf(a, b, next.head<2>());
    if (isLeft(a, b, d)) {
      kept.push_back(one);
    }
    if (isLeft(a, b, d) != isLeft(a, b, e)) {
      kept.push_back(one + d / (d - e) * (next - one));
    }
  }
  polygon = std::move(kept);
}

bool segmentsMeet(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d)
{
  const auto within = [](const Vector2d& p, const Vector2d& q, const Vector2d& x) {
    return (x.array() >= p.array().min(q.array())).all() &&
           (x.array() <= p.array().max(q.array())).all();
  };
  const double ac = cross(b - a, c - a), ad = cross(b - a, d - a);
  const double ca = cross(d - c, a - c), cb = cross(d - c, b - c);
  if (((ac > 0.0) != (ad > 0.0)) && ((ca > 0.0) != (cb > 0.0)) && ac != 0.0 && ad != 0.0 &&
      ca != 0.0 && cb != 0.0) {
    return true;
  }
  return (ac == 0.0 && within(a, b, c)) || (ad == 0.0 && within(a, b, d)) ||
         (ca == 0.0 && within(c, d, a)) || (cb == 0.0 && within(c, d, b));
}

}  // namespace

Vector2d twiceAreas(const std::vector<Vector3d>& polygon)
{
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    sum += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
  }
  return {sum.norm(), std::abs(sum[2])};
}

Outline::Outline(std::vector<Vector2d> corners) : corners_(std::move(corners))
{
  low_ = high_ = corners_[0];
  for (const Vector2d& corner : corners_) {
    low_ = low_.cwiseMin(corner);
    high_ = high_.cwiseMax(corner);
  }
  for (std::size_t i = 1; i + 1 < corners_.size(); ++i) {
    area_ += 0.5 * cross(corners_[i] - corners_[0], corners_[i + 1] - corners_[0]);
  }
  refuse();
}

double Outline::area() const
{
  return std::abs(area_);
}

bool Outline::contains(const Vector2d& point) const
{
  bool inside = false;
  visitSides([&](const Vector2d& a, const Vector2d& b) {
    if ((a[1] > point[1]) != (b[1] > point[1]) &&
        point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) {
      inside = !inside;
    }
  });
  return inside;
}

bool Outline::meets(const Vector2d& a, const Vector2d& b) const
{
  bool found = contains(a) || contains(b);
  visitSides(
      [&](const Vector2d& c, const Vector2d& d) { found = found || segmentsMeet(a, b, c, d); });
  return found;
}

bool Outline::isNear(const Vector2d& low, const Vector2d& high) const
{
  return (low.array() <= high_.array() + BESIDE).all() &&
         (high.array() >= low_.array() - BESIDE).all();
}

bool Outline::cuts(const Vector2d& low, const Vector2d& high) const
{
  bool found = false;
  visitSides([&](const Vector2d& a, const Vector2d& b) {
    if (found || (a.cwiseMax(b).array() < low.array()).any() ||
        (a.cwiseMin(b).array() > high.array()).any()) {
      return;
    }
    const Vector2d half = 0.5 * (high - low), normal(b[1] - a[1], a[0] - b[0]);
    const double distance = std::abs(normal.dot(0.5 * (low + high) - a));
    found = distance <= normal.cwiseAbs().dot(half);
  });
  return found;
}

Vector2d Outline::within(const Polygon& face) const
{
  // It is the sum of the triangles of its sides with the first corner, with their signs.
  Vector2d sum = Vector2d::Zero();
  for (std::size_t i = 1; i + 1 < corners_.size(); ++i) {
    const Vector2d& a = corners_[0];
    const double turn = cross(corners_[i] - a, corners_[i + 1] - a);
    if (turn == 0.0) {
      continue;
    }
    const Vector2d& b = turn > 0.0 ? corners_[i] : corners_[i + 1];
    const Vector2d& c = turn > 0.0 ? corners_[i + 1] : corners_[i];
    Polygon part = face;
    clip(part, a, b);
    clip(part, b, c);
    clip(part, c, a);
    sum += (turn > 0.0 ? 0.5 : -0.5) * twiceAreas(part);
  }
  return area_ > 0.0 ? sum : Vector2d(-sum);
}

void Outline::refuse() const
{
  const std::size_t n = corners_.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      const bool beside = i == 0 && j == n - 1;
      if (!beside &&
          segmentsMeet(corners_[i], corners_[i + 1], corners_[j], corners_[(j + 1) % n])) {
        throw std::invalid_argument("the outline crosses itself, by its sides " +
                                    std::to_string(i + 1) + " and " + std::to_string(j + 1));
      }
    }
  }
  const double size = (high_ - low_).norm();
  if (area() <= 1e-9 * size * size) {
    throw std::invalid_argument("the outline has no area: its corners lie in a line");
  }
}

}  // namespace rviz_mesh_plugin
