#pragma once

#include <array>
#include <cmath>

namespace mesh_map {

constexpr double PI = 3.14159265358979323846;

/// Two and three coordinates in double precision.
using Vector2 = std::array<double, 2>;
using Vector3 = std::array<double, 3>;

inline Vector2 operator+(const Vector2& a, const Vector2& b)
{
  return {a[0] + b[0], a[1] + b[1]};
}

inline Vector3 operator+(const Vector3& a, const Vector3& b)
{
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline Vector2 operator-(const Vector2& a, const Vector2& b)
{
  return {a[0] - b[0], a[1] - b[1]};
}

inline Vector3 operator-(const Vector3& a, const Vector3& b)
{
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline Vector2 operator-(const Vector2& a)
{
  return {-a[0], -a[1]};
}

inline Vector3 operator-(const Vector3& a)
{
  return {-a[0], -a[1], -a[2]};
}

inline Vector2 operator*(double factor, const Vector2& a)
{
  return {factor * a[0], factor * a[1]};
}

inline Vector3 operator*(double factor, const Vector3& a)
{
  return {factor * a[0], factor * a[1], factor * a[2]};
}

inline Vector2 operator/(const Vector2& a, double divisor)
{
  return {a[0] / divisor, a[1] / divisor};
}

inline Vector3 operator/(const Vector3& a, double divisor)
{
  return {a[0] / divisor, a[1] / divisor, a[2] / divisor};
}

inline double dot(const Vector2& a, const Vector2& b)
{
  return a[0] * b[0] + a[1] * b[1];
}

inline double dot(const Vector3& a, const Vector3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// > 0 where b is to the left of a.
inline double cross(const Vector2& a, const Vector2& b)
{
  return a[0] * b[1] - a[1] * b[0];
}

inline Vector3 cross(const Vector3& a, const Vector3& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double norm(const Vector2& a)
{
  return std::sqrt(dot(a, a));
}

inline double norm(const Vector3& a)
{
  return std::sqrt(dot(a, a));
}

inline double distance(const Vector3& a, const Vector3& b)
{
  return norm(b - a);
}

/// From 0 to pi; 0 where one of them is 0 (no product of -0 makes it pi).
inline double angleBetween(const Vector3& a, const Vector3& b)
{
  return std::atan2(norm(cross(a, b)), dot(a, b) + 0.0);
}

/// Of 3 numbers.
template <class Number>
bool isFinite(const Number* a)
{
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

inline bool isFinite(const Vector3& a)
{
  return isFinite(a.data());
}

/// A corner of a triangle.
inline Vector3 pointOf(const float* corner)
{
  return {double{corner[0]}, double{corner[1]}, double{corner[2]}};
}

/// b - a of two corners of a triangle.
inline Vector3 difference(const float* b, const float* a)
{
  return {double{b[0]} - a[0], double{b[1]} - a[1], double{b[2]} - a[2]};
}

/// The normal of a triangle; it is as long as twice its area. Differences of floats and their
/// products are exact enough in double that one far from the origin has the same as near it.
inline Vector3 triangleNormal(const float* a, const float* b, const float* c)
{
  return cross(difference(b, a), difference(c, a));
}

/// Weights (beta, gamma) of the second and third corner of a triangle at the foot of a point on its
/// plane: equation (1) of the paper (W. Heidrich: Computing the Barycentric Coordinates of a
/// Projected Point, 2005). `u` and `v` are its sides from the first corner, `n` is u x v, and `gap`
/// leads from that corner to the point. NaN for a triangle without area.
inline Vector2 barycentricWeights(const Vector3& u, const Vector3& v, const Vector3& n,
                                  const Vector3& gap)
{
  return Vector2{dot(cross(gap, v), n), dot(cross(u, gap), n)} / dot(n, n);
}

}  // namespace mesh_map
