#pragma once

#include <mesh_map/bvh/closest/bvh_closest.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "bvh/closest/normal_filter.h"
#include "core/support/test_meshes.h"

using Point = std::array<double, 3>;

inline bool isFinite(const Point& point)
{
  return std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
}

/// Whether the normal of a triangle (9 floats) is within an angle of a unit direction.
inline bool normalWithin(const float* corners, const Point& direction, double max_angle)
{
  const mesh_map::NormalFilter filter(direction.data(), max_angle);
  return filter.valid() && filter(corners);
}

/// The closest point by looking at every face in turn. A normal has length 1.
inline mesh_map::SurfaceHit lookAtEveryFace(const TestMesh& mesh, const Point& point,
                                            double max_distance = INFINITY,
                                            const std::vector<std::uint8_t>& mask = {},
                                            const Point* normal = nullptr, double max_angle = 0.0)
{
  mesh_map::SurfaceHit best;
  best.distance = max_distance;
  for (std::size_t f = 0; f < mesh.faceCount() && isFinite(point); ++f) {
    if ((!mask.empty() && mask[f] == 0) ||
        (normal != nullptr && !normalWithin(mesh.corners(f).data(), *normal, max_angle))) {
      continue;
    }
    mesh_map::SurfaceHit hit = mesh_map::closestPointOnTriangle(
        mesh.corner(f, 0), mesh.corner(f, 1), mesh.corner(f, 2), point.data());
    if (hit.distance < best.distance ||
        (hit.distance == best.distance && best.face == mesh_map::NO_INDEX)) {
      hit.face = static_cast<std::uint32_t>(f);
      best = hit;
    }
  }
  return best.face == mesh_map::NO_INDEX ? mesh_map::SurfaceHit() : best;
}

/// Equal to the last bit.
inline void expectSame(const mesh_map::SurfaceHit& found, const mesh_map::SurfaceHit& expected,
                       const std::string& what)
{
  EXPECT_EQ(found.face, expected.face) << what;
  EXPECT_EQ(found.distance, expected.distance) << what;
  EXPECT_EQ(found.position, expected.position) << what;
  EXPECT_EQ(found.barycentric, expected.barycentric) << what;
}

inline std::string text(const Point& point)
{
  return "point " + std::to_string(point[0]) + " " + std::to_string(point[1]) + " " +
         std::to_string(point[2]);
}

/// Points at, near and far from a mesh, among them those that several faces are as near to.
inline std::vector<Point> pointsAround(const TestMesh& mesh, std::size_t of_each)
{
  std::mt19937 random(17);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::normal_distribution<double> any(0.0, 1.0);
  std::uniform_int_distribution<std::size_t> some_face(0, mesh.faceCount() - 1);
  const auto mix = [&](double a, double b, double c) {
    const std::size_t face = some_face(random);
    Point result;
    for (std::size_t i = 0; i < 3; ++i) {
      result[i] =
          a * mesh.corner(face, 0)[i] + b * mesh.corner(face, 1)[i] + c * mesh.corner(face, 2)[i];
    }
    return result;
  };
  const auto moved = [&](Point point, double by) {
    for (double& x : point) {
      x += by * any(random);
    }
    return point;
  };
  std::vector<Point> points;
  for (std::size_t i = 0; i < of_each; ++i) {
    const double a = place(random), b = (1.0 - a) * place(random);
    points.push_back(mix(1, 0, 0));
    points.push_back(mix(0.5, 0.5, 0));
    points.push_back(mix(1.0 / 3, 1.0 / 3, 1.0 / 3));
    points.push_back(mix(a, b, 1.0 - a - b));
    for (const double by : {1e-9, 1e-4, 0.05, 1.0, 30.0, 1e3, 1e6, 1e9, 1e12, 1e15, 1e18}) {
      points.push_back(moved(mix(a, b, 1.0 - a - b), by));
    }
    points.push_back(moved(mix(1, 0, 0), 1e-9));  // less than what floats tell apart
    // high above, along an axis: many are as near when rounded
    Point above = mix(1, 0, 0);
    above[i % 3] = std::pow(10.0, 3.0 + 17.0 * place(random));
    points.push_back(above);
  }
  for (const double x : {1e20, 1e38, 1e60, 1e139, 1e140, 1e141, 1e200, 1e300, 1e308}) {
    points.push_back({x, 0.0, 0.0});
    points.push_back({0.5 * x, -x, 0.7 * x});
  }
  points.push_back({0.0, 0.0, 0.0});
  points.push_back({-0.0, 5e-324, 1e-310});
  points.push_back({0.5, 0.5, 0.5});  // the middle of the cube: six sides are as near
  return points;
}
