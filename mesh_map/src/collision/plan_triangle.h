#pragma once

#include <array>
#include <cstddef>

#include "base/vector3.h"
#include "bvh/rays/ray_test.h"

namespace mesh_map {

/// Whether the vertical line through a point runs through a triangle (9 floats), and at which
/// height.
///
/// The line is moved by less than any number along x, and by less than that along y: so it never
/// runs through an edge or a corner, and of a closed surface through an even number of triangles
/// beyond a point outside of it, an odd one beyond a point inside (H. Edelsbrunner, E. Mücke:
/// Simulation of Simplicity, 1990; signs of determinants are exact).
inline bool crossesLine(const float* corners, const Vector3& point, double* height)
{
  std::array<double, 3> x, y, weight;
  for (std::size_t k = 0; k < 3; ++k) {
    x[k] = corners[3 * k] - point[0];
    y[k] = corners[3 * k + 1] - point[1];
  }
  bool inside = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const double side = determinant(x[k], y[k], x[next], y[next]);
    weight[(k + 2) % 3] = side;
    if ((y[k] > 0.0) != (y[next] > 0.0)) {
      inside ^= y[next] > y[k] ? side > 0.0 : side < 0.0;
    }
  }
  if (!inside) {
    return false;
  }
  const double sum = weight[0] + weight[1] + weight[2];
  const double a = corners[2], b = corners[5], c = corners[8];
  *height = sum != 0.0 ? a + (weight[1] * (b - a) + weight[2] * (c - a)) / sum : (a + b + c) / 3.0;
  return true;
}

}  // namespace mesh_map
