#pragma once

#include <mesh_map/bvh/rays/bvh_rays.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/support/test_meshes.h"

using Point = std::array<double, 3>;
using Rays = std::vector<mesh_map::Ray>;

inline Point between(const Point& a, const Point& b, double weight)
{
  return {a[0] + weight * (b[0] - a[0]), a[1] + weight * (b[1] - a[1]),
          a[2] + weight * (b[2] - a[2])};
}

inline mesh_map::Ray rayTo(const Point& origin, const Point& target)
{
  return {origin, {target[0] - origin[0], target[1] - origin[1], target[2] - origin[2]}};
}

/// Sources of rays about a mesh, the same at every run.
class RaySamples
{
 public:
  explicit RaySamples(const TestMesh& mesh, unsigned seed = 1) : mesh_(mesh), random_(seed)
  {
    // The giant triangle does not count: rays should be about where the others are.
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      if (mesh.name.find("giant") == std::string::npos || i + 9 < mesh.positions.size()) {
        lower_[i % 3] = std::min(lower_[i % 3], double{mesh.positions[i]});
        upper_[i % 3] = std::max(upper_[i % 3], double{mesh.positions[i]});
      }
    }
  }

  double number(double from, double to)
  {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }
  std::size_t index(std::size_t count)
  {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_);
  }
  Point center() const { return between(lower_, upper_, 0.5); }
  double size() const
  {
    return std::hypot(upper_[0] - lower_[0], upper_[1] - lower_[1], upper_[2] - lower_[2]);
  }

  /// A point in the box of the mesh, made larger.
  Point point(double larger = 1.5)
  {
    Point p = center();
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] += larger * 0.5 * (upper_[k] - lower_[k] + 0.1 * size()) * number(-1.0, 1.0);
    }
    return p;
  }
  Point direction()
  {
    std::normal_distribution<double> side;
    return {side(random_), side(random_), side(random_)};
  }
  Point vertex()
  {
    const std::size_t v = index(mesh_.positions.size() / 3);
    return {mesh_.positions[3 * v], mesh_.positions[3 * v + 1], mesh_.positions[3 * v + 2]};
  }
  Point corner(std::size_t face, std::size_t k) const
  {
    const float* const p = mesh_.corner(face, k % 3);
    return {p[0], p[1], p[2]};
  }
  /// A point of an edge, in floats, so that it may be on it exactly.
  Point edgePoint()
  {
    const std::size_t face = index(mesh_.faceCount()), k = index(3);
    return between(corner(face, k), corner(face, k + 1), 0.25 * static_cast<double>(index(5)));
  }
  Point surfacePoint()
  {
    const std::size_t face = index(mesh_.faceCount());
    return between(corner(face, 0), between(corner(face, 1), corner(face, 2), number(0, 1)),
                   number(0, 1));
  }

  Rays anywhere(std::size_t count)
  {
    Rays rays;
    while (rays.size() < count) {
      rays.push_back(rays.size() % 2 == 0 ? mesh_map::Ray{point(3.0), direction()}
                                          : rayTo(point(3.0), surfacePoint()));
    }
    return rays;
  }

  /// A picture of columns x rows, row by row, of any place and view.
  Rays picture(std::size_t columns, std::size_t rows)
  {
    const Point eye = point(4.0), middle = surfacePoint(), right = direction(), up = direction();
    Rays rays;
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t column = 0; column < columns; ++column) {
        const double x = (static_cast<double>(column) + 0.5) / static_cast<double>(columns) - 0.5;
        const double y = (static_cast<double>(row) + 0.5) / static_cast<double>(rows) - 0.5;
        Point target = middle;
        for (std::size_t k = 0; k < 3; ++k) {
          target[k] += 0.3 * size() * (x * right[k] + y * up[k]);
        }
        rays.push_back(rayTo(eye, target));
      }
    }
    return rays;
  }

  /// Through vertices and edges, from outside and from vertices and edges.
  Rays throughEdges(std::size_t count)
  {
    Rays rays;
    while (rays.size() < count) {
      const Point target = rays.size() % 2 == 0 ? vertex() : edgePoint();
      const std::size_t kind = rays.size() / 2 % 3;
      rays.push_back(rayTo(kind == 0 ? point(3.0) : kind == 1 ? vertex() : edgePoint(), target));
    }
    return rays;
  }

  /// Along axes, most of them on planes of boxes and in planes of faces.
  Rays alongAxes(std::size_t count)
  {
    Rays rays;
    while (rays.size() < count) {
      const std::size_t kind = rays.size() % 4, axis = index(3);
      mesh_map::Ray ray{kind == 0 ? point() : kind == 1 ? surfacePoint() : vertex(), {}};
      ray.origin[axis] += kind == 3 ? 0.0 : number(-2.0, 2.0) * size();
      ray.direction[axis] = index(2) == 0 ? 1.0 : -1.0;
      if (rays.size() % 3 == 0) {
        ray.direction[(axis + 1) % 3] = std::array<double, 4>{-0.0, 1.0, -1.0, 1e-300}[index(4)];
      }
      rays.push_back(ray);
    }
    return rays;
  }

  /// Within the planes of faces, up to rounding.
  Rays inFaces(std::size_t count)
  {
    Rays rays;
    while (rays.size() < count) {
      const std::size_t face = index(mesh_.faceCount());
      const Point a = corner(face, 0), b = corner(face, 1), c = corner(face, 2);
      rays.push_back(rayTo(between(a, between(b, c, number(-2, 2)), number(-2, 2)),
                           between(a, between(b, c, number(0, 1)), number(0, 1))));
    }
    return rays;
  }

  /// From the surface.
  Rays fromSurface(std::size_t count)
  {
    Rays rays;
    while (rays.size() < count) {
      rays.push_back({rays.size() % 2 == 0 ? surfacePoint() : vertex(), direction()});
    }
    return rays;
  }

  /// From far away towards the mesh, in any direction and along axes.
  Rays fromAfar(double distance, std::size_t count)
  {
    Rays rays;
    while (rays.size() < count) {
      const Point target = rays.size() % 2 == 0 ? surfacePoint() : vertex();
      Point way = direction();
      const std::size_t axis = index(3);
      if (rays.size() % 3 == 0) {
        way = {0.0, 0.0, 0.0};
        way[axis] = index(2) == 0 ? 1.0 : -1.0;
      } else if (rays.size() % 3 == 1) {
        way[axis] *= 1e-6;
      }
      Point origin = target;
      for (std::size_t k = 0; k < 3; ++k) {
        origin[k] -= distance * way[k];
      }
      rays.push_back({origin, way});
    }
    return rays;
  }

  /// With directions as short and as long as doubles go.
  Rays ofAnyLength(std::size_t count)
  {
    const double lengths[] = {5e-324, 1e-310, 1e-200, 1e-30, 1e30, 1e160, 1e308};
    Rays rays = anywhere(count);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      double largest = 0.0;
      for (const double d : rays[i].direction) {
        largest = std::max(largest, std::abs(d));
      }
      for (double& d : rays[i].direction) {
        d = d / largest * lengths[i % 7];
      }
    }
    return rays;
  }

  /// Rays of which each has at least one number from a list of nasty ones.
  Rays garbage(std::size_t count)
  {
    constexpr double INF = std::numeric_limits<double>::infinity();
    const double nasty[] = {std::nan(""), INF, -INF, 0.0, -0.0, 5e-324, 1e-300, -1e300, 1.797e308};
    Rays rays = anywhere(count);
    for (mesh_map::Ray& ray : rays) {
      for (std::size_t n = index(7) + 1; n > 0; --n) {
        const std::size_t place = index(7);
        double& value = place < 3 ? ray.origin[place]
                                  : (place < 6 ? ray.direction[place - 3] : ray.max_distance);
        value = nasty[index(9)];
      }
    }
    return rays;
  }

  /// Rays that end before, at and behind what they hit.
  Rays limited(std::size_t count)
  {
    Rays rays = anywhere(count);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double limits[] = {0.0,    -1.0, size(), 0.3 * size(), number(0.0, 2.0) * size(),
                               1e-300, 1e300};
      rays[i].max_distance = limits[i % 7];
    }
    return rays;
  }

  /// All of the above.
  Rays all(std::size_t count)
  {
    Rays rays;
    for (const Rays& more :
         {anywhere(count), picture(count / 4, 4), throughEdges(count), alongAxes(count),
          inFaces(count), fromSurface(count), fromAfar(1e3, count / 2), fromAfar(1e6, count / 2),
          fromAfar(1e9, count / 2), fromAfar(1e12, count / 2), fromAfar(1e15, count / 2),
          fromAfar(1e17, count / 4), fromAfar(1e20, count / 4), fromAfar(1e150, count / 4),
          fromAfar(1e300, count / 4), ofAnyLength(count / 2), garbage(count), limited(count)}) {
      rays.insert(rays.end(), more.begin(), more.end());
    }
    return rays;
  }

 private:
  const TestMesh& mesh_;
  std::mt19937 random_;
  Point lower_{1e300, 1e300, 1e300}, upper_{-1e300, -1e300, -1e300};
};
