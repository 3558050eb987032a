#pragma once

#include <mesh_map/bvh/selection/region.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "core/support/test_meshes.h"

/// Many queries about a mesh, random ones and such that are hard for what computes with floats.
struct TestQueries
{
  std::vector<double> origins, directions, max_distances, points;
  std::vector<mesh_map::SphereRegion> spheres;
  std::vector<mesh_map::ConvexRegion> convexes;
  std::vector<std::uint8_t> mask;

  TestQueries(const TestMesh& mesh, unsigned count, unsigned seed = 1) : mesh_(mesh), random_(seed)
  {
    addRandom(count);
    addExact(count);
    addStrange();
    addRegions();
    std::uniform_int_distribution<unsigned> coin(0, 2);
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
      mask.push_back(coin(random_) == 0 ? 0 : 1);
    }
  }

 private:
  using Point = std::array<double, 3>;

  double number(double low, double high)
  {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  /// Of a face: a corner, a point of an edge, or any point.
  Point onFace(unsigned kind)
  {
    const std::size_t face = random_() % mesh_.faceCount();
    double b = number(0.0, 1.0), c = number(0.0, 1.0 - b);
    if (kind == 0) {
      b = c = 0.0;
    } else if (kind == 1) {
      b = random_() % 2 == 0 ? 0.5 : b;
      c = 0.0;
    }
    Point point;
    for (std::size_t k = 0; k < 3; ++k) {
      const double a = mesh_.corner(face, 0)[k];
      point[k] = a + b * (mesh_.corner(face, 1)[k] - a) + c * (mesh_.corner(face, 2)[k] - a);
    }
    return point;
  }

  Point near(const Point& point, double by)
  {
    return {point[0] + number(-by, by), point[1] + number(-by, by), point[2] + number(-by, by)};
  }

  void addRay(const Point& origin, const Point& direction,
              double max_distance = std::numeric_limits<double>::infinity())
  {
    origins.insert(origins.end(), origin.begin(), origin.end());
    directions.insert(directions.end(), direction.begin(), direction.end());
    max_distances.push_back(max_distance);
  }

  void addRayThrough(const Point& origin, const Point& target,
                     double max_distance = std::numeric_limits<double>::infinity())
  {
    addRay(origin, {target[0] - origin[0], target[1] - origin[1], target[2] - origin[2]},
           max_distance);
  }

  void addPoint(const Point& point) { points.insert(points.end(), point.begin(), point.end()); }

  void addRandom(unsigned count)
  {
    for (unsigned i = 0; i < count; ++i) {
      const Point target = onFace(2);
      const double away = std::pow(10.0, number(-3.0, 2.0));
      addRayThrough(near(target, away), near(target, 0.1 * away));
      addRayThrough(near(target, away), target, number(0.0, 2.0 * away));
      addPoint(near(target, away));
      addPoint(near(target, 1e-3));
    }
  }

  /// Corners, edges, axes, and the surface itself.
  void addExact(unsigned count)
  {
    for (unsigned i = 0; i < count; ++i) {
      const Point target = onFace(i % 3), other = onFace((i + 1) % 3);
      const Point eye = near(target, 5.0);
      addRayThrough(eye, target);
      addRayThrough(
          eye, target,
          std::hypot(std::hypot(target[0] - eye[0], target[1] - eye[1]), target[2] - eye[2]));
      addRayThrough(target, other);
      addRayThrough(target, eye);
      for (double away : {1e4, 1e6, 1e9, 1e12}) {
        addRayThrough(near(target, away), target);
        addPoint(near(target, away));
      }
      Point axis{}, before = target;
      axis[i % 3] = i % 2 == 0 ? 1.0 : -1.0;
      before[i % 3] -= 2.0 * axis[i % 3];
      addRay(before, axis);
      addRay(target, axis);
      axis[(i + 1) % 3] = 1.0;
      addRay(before, axis);
      axis[(i + 1) % 3] = 1e-30;
      addRay(before, axis);
      addPoint(target);
      addPoint(before);
    }
  }

  void addStrange()
  {
    const Point target = onFace(2);
    const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
    for (double value : {nan, inf, -inf, 1e300, -1e300, 1e40, 1e20, 1e16, 0.0, -0.0, 5e-324}) {
      for (std::size_t k = 0; k < 3; ++k) {
        Point changed = target;
        changed[k] = value;
        addPoint(changed);
        addRayThrough(changed, target);
        addRay(changed, {0.3, -0.2, 1.0});
        addRay(target, changed);
        addRay(near(target, 1.0), {value, value, value});
      }
      addRayThrough(near(target, 3.0), target, value);
    }
    addRay(target, {0.0, 0.0, 0.0});
  }

  void addSphere(const Point& center, double radius) { spheres.emplace_back(center, radius); }

  void addRegions()
  {
    const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
    for (unsigned i = 0; i < 30; ++i) {
      const Point center = near(onFace(i % 3), i % 2 == 0 ? 0.0 : 0.5);
      const Point other = onFace(0);
      const double size = std::pow(10.0, number(-3.0, 1.0));
      addSphere(center, size);
      addSphere(center, std::hypot(std::hypot(other[0] - center[0], other[1] - center[1]),
                                   other[2] - center[2]));
      const double turn = i % 3 == 0 ? 0.0 : number(-3.0, 3.0), c = std::cos(turn),
                   s = std::sin(turn);
      convexes.push_back(
          mesh_map::ConvexRegion::box(center, {{{c, s, 0.0}, {-s, c, 0.0}, {0.0, 0.0, 1.0}}},
                                      {size, size * number(0.1, 2.0), size * number(0.1, 2.0)}));
    }
    const Point center = onFace(2);
    for (double value : {nan, inf, 1e300, 1e20, 1e9, 0.0, -1.0}) {
      addSphere(center, value);
      addSphere({value, center[1], center[2]}, 1.0);
      addSphere({value, center[1], center[2]}, value);
      convexes.push_back(mesh_map::ConvexRegion({{value, 1.0, 0.0, -center[1]}}));
      convexes.push_back(
          mesh_map::ConvexRegion({{0.0, 0.0, 1.0, value}, {1.0, 0.0, 0.0, -center[0]}}));
    }
  }

  const TestMesh& mesh_;
  std::mt19937 random_;
};
