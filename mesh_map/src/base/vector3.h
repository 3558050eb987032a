#ifndef MESH_MAP_SRC_BASE_VECTOR3_H
#define MESH_MAP_SRC_BASE_VECTOR3_H

#include <array>
#include <cmath>

namespace mesh_map {

/// Three coordinates in double precision.
using Vector3 = std::array<double, 3>;

inline Vector3 operator-(const Vector3& a, const Vector3& b)
{
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// b - a of two corners of a triangle.
inline Vector3 difference(const float* b, const float* a)
{
  return {double{b[0]} - a[0], double{b[1]} - a[1], double{b[2]} - a[2]};
}

inline double dot(const Vector3& a, const Vector3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vector3 cross(const Vector3& a, const Vector3& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline bool isFinite(const Vector3& a)
{
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_BASE_VECTOR3_H
