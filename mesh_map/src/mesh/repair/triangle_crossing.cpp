#include "mesh/repair/triangle_crossing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace mesh_map {
namespace {

constexpr double NEARLY = 1e-9;  // in parts of the size

double sizeOf(const Triangle& triangle)
{
  return std::max({distance(triangle[0], triangle[1]), distance(triangle[1], triangle[2]),
                   distance(triangle[2], triangle[0])});
}

/// Whether a segment passes through a triangle, borders included.
bool passes(const Vector3& p, const Vector3& q, const Triangle& triangle, double size)
{
  const Vector3 u = triangle[1] - triangle[0], v = triangle[2] - triangle[0], n = cross(u, v);
  const double length = norm(n);
  if (!(length > NEARLY * size * size)) {
    return false;
  }
  const double above_p = dot(p - triangle[0], n) / length,
               above_q = dot(q - triangle[0], n) / length;
  const double margin = NEARLY * size;
  if (std::max(above_p, above_q) <= margin || std::min(above_p, above_q) >= -margin) {
    return false;  // on one side, or in the plane
  }
  const Vector3 at = p + above_p / (above_p - above_q) * (q - p);
  const Vector2 weights = barycentricWeights(u, v, n, at - triangle[0]);
  return weights[0] >= -NEARLY && weights[1] >= -NEARLY && weights[0] + weights[1] <= 1.0 + NEARLY;
}

bool contains(const std::array<Vector2, 3>& triangle, const Vector2& point)
{
  double sides[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector2 side = triangle[(k + 1) % 3] - triangle[k];
    sides[k] = cross(side, point - triangle[k]) / std::max(dot(side, side), 1e-300);
  }
  constexpr double inside = 1e-6;
  return (sides[0] > inside && sides[1] > inside && sides[2] > inside) ||
         (sides[0] < -inside && sides[1] < -inside && sides[2] < -inside);
}

bool segmentsCross(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& d)
{
  const double scale = std::max(dot(b - a, b - a), dot(d - c, d - c));
  const double margin = 1e-6 * scale;
  const double one = cross(b - a, c - a), two = cross(b - a, d - a);
  const double three = cross(d - c, a - c), four = cross(d - c, b - c);
  return ((one > margin && two < -margin) || (one < -margin && two > margin)) &&
         ((three > margin && four < -margin) || (three < -margin && four > margin));
}

/// Of triangles in one plane.
bool overlap(const Triangle& one, const Triangle& other, const Vector3& normal)
{
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    axis = std::abs(normal[k]) > std::abs(normal[axis]) ? k : axis;
  }
  const auto flat = [axis](const Triangle& triangle) {
    std::array<Vector2, 3> result;
    for (std::size_t k = 0; k < 3; ++k) {
      result[k] = {triangle[k][(axis + 1) % 3], triangle[k][(axis + 2) % 3]};
    }
    return result;
  };
  const auto a = flat(one), b = flat(other);
  const auto middle = [](const std::array<Vector2, 3>& t) { return (t[0] + t[1] + t[2]) / 3.0; };
  if (contains(a, middle(b)) || contains(b, middle(a))) {
    return true;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (contains(a, b[i]) || contains(b, a[i])) {
      return true;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (segmentsCross(a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3])) {
        return true;
      }
    }
  }
  return false;
}

bool inPlaneOf(const Triangle& one, const Triangle& other, double size)
{
  const Vector3 n = cross(one[1] - one[0], one[2] - one[0]);
  const double length = norm(n);
  return length > NEARLY * size * size &&
         std::all_of(other.begin(), other.end(), [&](const Vector3& point) {
           return std::abs(dot(point - one[0], n)) <= 1e-6 * size * length;
         });
}

}  // namespace

bool trianglesCross(const Triangle& one, unsigned shared_of_one, const Triangle& other,
                    unsigned shared_of_other)
{
  const auto several = [](unsigned mask) { return (mask & (mask - 1)) != 0; };
  if (several(shared_of_one) || several(shared_of_other)) {
    return false;
  }
  const double size = std::max(sizeOf(one), sizeOf(other));
  for (unsigned k = 0; k < 3; ++k) {
    const unsigned sides = (1u << k) | (1u << (k + 1) % 3);
    if (((sides & shared_of_one) == 0 && passes(one[k], one[(k + 1) % 3], other, size)) ||
        ((sides & shared_of_other) == 0 && passes(other[k], other[(k + 1) % 3], one, size))) {
      return true;
    }
  }
  return inPlaneOf(one, other, size) && inPlaneOf(other, one, size) &&
         overlap(one, other, cross(one[1] - one[0], one[2] - one[0]));
}

}  // namespace mesh_map
