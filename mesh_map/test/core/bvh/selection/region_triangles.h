#pragma once

#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/selection/region.h>

#include <gtest/gtest.h>

#include <functional>

#include "regions.h"

/// How far a point is within a region (negative: outside), by other means than the region's.
using Depth = std::function<double(const Vector&)>;

using Triangle = std::array<float, 9>;

inline Vector pointOf(const Triangle& triangle, double b, double c)
{
  Vector point;
  for (std::size_t i = 0; i < 3; ++i) {
    point[i] = (1.0 - b - c) * triangle[i] + b * triangle[3 + i] + c * triangle[6 + i];
  }
  return point;
}

/// The greatest depth of a concave function over a triangle, by nested thirds.
inline double deepest(const Triangle& triangle, const Depth& depth)
{
  const auto greatest = [](const std::function<double(double)>& f) {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 60; ++i) {
      const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
      (f(a) < f(b) ? low : high) = f(a) < f(b) ? a : b;
    }
    return std::max({f(low), f(0.0), f(1.0)});
  };
  return greatest([&](double b) {
    return greatest([&](double c) { return depth(pointOf(triangle, b, c * (1.0 - b))); });
  });
}

/// Triangles about the cube from -1 to 1: large, small, needles, segments and points.
inline Triangle anyTriangle(std::mt19937& random)
{
  std::uniform_real_distribution<float> place(-1.5f, 1.5f);
  const float size = std::pow(10.0f, std::uniform_real_distribution<float>(-3.0f, 1.5f)(random));
  const float center[3] = {place(random), place(random), place(random)};
  Triangle triangle;
  for (std::size_t i = 0; i < 9; ++i) {
    triangle[i] = center[i % 3] + size * place(random);
  }
  const unsigned kind = random() % 8;
  for (std::size_t i = 0; i < 3 && kind < 3; ++i) {
    triangle[3 + i] = kind == 0 ? triangle[i] : triangle[3 + i];
    triangle[6 + i] = kind < 2 ? triangle[i] : 0.5f * (triangle[i] + triangle[3 + i]);
  }
  return triangle;
}

/// What a region says of a triangle is true of points of it, and of its witness.
/// Returns what it says.
inline mesh_map::Side check(const mesh_map::Region& region, const Triangle& triangle,
                            const Depth& depth, double rounding)
{
  using mesh_map::Side;
  const Side side = region.triangle(triangle.data());
  for (int i = 0; i <= 12; ++i) {
    for (int j = 0; i + j <= 12; ++j) {
      const Vector point = pointOf(triangle, i / 12.0, j / 12.0);
      const double deep = depth(point);
      EXPECT_TRUE(region.contains(point) ? deep >= -rounding : deep <= rounding) << deep;
      EXPECT_FALSE(side == Side::OUTSIDE && deep > rounding) << deep;
      EXPECT_FALSE(side == Side::INSIDE && deep < -rounding) << deep;
    }
  }
  std::size_t corners = 0;
  for (std::size_t k = 0; k < 9; k += 3) {
    corners += region.contains({triangle[k], triangle[k + 1], triangle[k + 2]}) ? 1 : 0;
  }
  EXPECT_FALSE(corners > 0 && side == Side::OUTSIDE);
  EXPECT_FALSE(corners < 3 && side == Side::INSIDE);
  if (side != Side::OUTSIDE) {
    const Vector witness = region.witness(triangle.data());
    EXPECT_GE(depth(witness), -rounding);
    EXPECT_LE(mesh_map::closestPointOnTriangle(triangle.data(), triangle.data() + 3,
                                               triangle.data() + 6, witness.data())
                  .distance,
              1e-7);  // which is what it is wrong by for needles
  }
  return side;
}
