#pragma once

#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/selection/region.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/support/test_meshes.h"

/// Regions that tests select faces with, and what they are compared with.
using Vector = std::array<double, 3>;
using Matrix = std::array<double, 16>;
using Polygon = std::vector<mesh_map::LassoRegion::Point>;

struct NamedRegion
{
  std::string name;
  std::unique_ptr<mesh_map::Region> region;
};

inline std::vector<std::uint32_t> bruteForce(const TestMesh& mesh, const mesh_map::Region& region,
                                             mesh_map::SelectionMode mode,
                                             const std::vector<std::uint8_t>& mask = {})
{
  std::vector<std::uint32_t> faces;
  for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
    const mesh_map::Side side = region.triangle(mesh.corners(face).data());
    if ((mask.empty() || mask[face] != 0) &&
        (side == mesh_map::Side::INSIDE ||
         (side == mesh_map::Side::TOUCHING && mode == mesh_map::SelectionMode::TOUCHING))) {
      faces.push_back(static_cast<std::uint32_t>(face));
    }
  }
  return faces;
}

inline mesh_map::Box boundsOf(const float* corners, std::size_t count)
{
  const double inf = std::numeric_limits<double>::infinity();
  mesh_map::Box box{{inf, inf, inf}, {-inf, -inf, -inf}};
  for (std::size_t i = 0; i < 3 * count; ++i) {
    box.lower[i % 3] = std::min(box.lower[i % 3], double{corners[i]});
    box.upper[i % 3] = std::max(box.upper[i % 3], double{corners[i]});
  }
  return box;
}

inline Matrix product(const Matrix& a, const Matrix& b)
{
  Matrix result{};
  for (std::size_t i = 0; i < 16; ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      result[i] += a[i / 4 * 4 + k] * b[4 * k + i % 4];
    }
  }
  return result;
}

inline Vector cross(const Vector& a, const Vector& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double dot(const Vector& a, const Vector& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vector unit(const Vector& a)
{
  const double length = std::sqrt(dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

/// Right-handed axes, the last along `way`.
inline std::array<Vector, 3> axesAlong(const Vector& way)
{
  const Vector last = unit(way);
  const Vector other = std::abs(last[2]) < 0.9 ? Vector{0, 0, 1} : Vector{1, 0, 0};
  const Vector first = unit(cross(other, last));
  return {first, cross(last, first), last};
}

/// From the mesh to the camera, which looks along its own -z.
inline Matrix viewOf(const Vector& eye, const Vector& target)
{
  const std::array<Vector, 3> axes =
      axesAlong({eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]});
  Matrix view{};
  for (std::size_t i = 0; i < 3; ++i) {
    std::copy(axes[i].begin(), axes[i].end(), view.begin() + 4 * i);
    view[4 * i + 3] = -dot(axes[i], eye);
  }
  view[15] = 1.0;
  return view;
}

/// `slope`: half the width of the picture over its distance.
inline Matrix perspective(double slope, double near, double far)
{
  return {1.0 / slope,
          0,
          0,
          0,
          0,
          1.0 / slope,
          0,
          0,
          0,
          0,
          (far + near) / (near - far),
          2.0 * far * near / (near - far),
          0,
          0,
          -1,
          0};
}

inline Matrix orthographic(double half_width, double near, double far)
{
  return {1.0 / half_width,
          0,
          0,
          0,
          0,
          1.0 / half_width,
          0,
          0,
          0,
          0,
          2.0 / (near - far),
          (far + near) / (near - far),
          0,
          0,
          0,
          1};
}

/// A camera's pyramid: left, right, bottom, top, near, far.
inline std::vector<mesh_map::Plane> frustumPlanes(const Matrix& view_projection)
{
  std::vector<mesh_map::Plane> planes;
  for (std::size_t row = 0; row < 3; ++row) {
    for (const double sign : {1.0, -1.0}) {
      mesh_map::Plane plane;
      for (std::size_t i = 0; i < 4; ++i) {
        plane[i] = view_projection[12 + i] + sign * view_projection[4 * row + i];
      }
      planes.push_back(plane);
    }
  }
  return planes;
}

/// Outlines of many kinds about a point of the picture: convex, concave, self-intersecting, thin.
inline std::vector<Polygon> outlines(double x, double y, double size, std::mt19937& random)
{
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Polygon square{
      {x - size, y - size}, {x + size, y - size}, {x + size, y + size}, {x - size, y + size}};
  Polygon star, pentagram, scribble, needle;
  for (int i = 0; i < 40; ++i) {
    const double angle = 2.0 * M_PI * i / 40.0, radius = size * (i % 2 == 0 ? 1.0 : 0.4);
    star.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle)});
  }
  for (int i = 0; i < 5; ++i) {
    const double angle = 4.0 * M_PI * i / 5.0 + 0.1;
    pentagram.push_back({x + size * std::cos(angle), y + size * std::sin(angle)});
  }
  for (int i = 0; i < 12; ++i) {
    scribble.push_back({x + size * any(random), y + size * any(random)});
  }
  needle = {{x - size, y}, {x + size, y + 1e-9}, {x + size, y + 2e-9}};
  return {square, star, pentagram, scribble, needle};
}

/// Regions of all kinds and sizes about a mesh, many of which are made to be on the brink.
inline std::vector<NamedRegion> regionsFor(const TestMesh& mesh, unsigned seed, int rounds = 6)
{
  using namespace mesh_map;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::uniform_int_distribution<std::size_t> any_face(0, mesh.faceCount() - 1);
  std::vector<NamedRegion> regions;
  const auto add = [&regions](const std::string& name, auto region) {
    regions.push_back({name, std::make_unique<decltype(region)>(std::move(region))});
  };
  const Box bounds = boundsOf(mesh.positions.data(), mesh.positions.size() / 3);
  Vector middle, half;
  for (std::size_t i = 0; i < 3; ++i) {
    middle[i] = 0.5 * (bounds.lower[i] + bounds.upper[i]);
    half[i] = 0.5 * (bounds.upper[i] - bounds.lower[i]);
  }
  const std::array<Vector, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const double size = std::max({half[0], half[1], half[2], 1e-3});
  add("the bounds", ConvexRegion::box(middle, axes, half));
  add("everything", SphereRegion(middle, 4.0 * size));
  add("half space through the middle", ConvexRegion({{0, 0, 1, -middle[2]}}));
  for (int round = 0; round < rounds; ++round) {
    const std::string number = " " + std::to_string(round);
    const std::vector<float> corners = mesh.corners(any_face(random));
    const Vector vertex{corners[0], corners[1], corners[2]};
    const double scale = size * std::pow(10.0, 2.0 * any(random) - 2.0);
    const Vector near{vertex[0] + scale * any(random), vertex[1] + scale * any(random),
                      vertex[2] + scale * any(random)};
    const Vector far{vertex[0] + 3.0 * size * any(random), vertex[1] + 3.0 * size * any(random),
                     vertex[2] + 3.0 * size * any(random)};
    add("ball" + number, SphereRegion(near, scale));
    add("ball of radius 0 on a vertex" + number, SphereRegion(vertex, 0.0));
    add("ball that reaches a vertex" + number,
        SphereRegion(far,
                     std::sqrt(std::pow(far[0] - vertex[0], 2) + std::pow(far[1] - vertex[1], 2) +
                               std::pow(far[2] - vertex[2], 2))));
    add("box" + number, ConvexRegion::box(near, axesAlong({any(random), any(random), 0.1}),
                                          {scale, 0.3 * scale, 2.0 * scale}));
    add("box at a vertex" + number,
        ConvexRegion::box({vertex[0] + scale, vertex[1] + scale, vertex[2] + scale}, axes,
                          {scale, scale, scale}));
    add("box without a size" + number, ConvexRegion::box(vertex, axes, {0, 0, 0}));
    const Matrix view = viewOf(far, near);
    const Matrix camera = product(perspective(0.5, 0.01 * size, 20.0 * size), view);
    const Matrix flat = product(orthographic(2.0 * scale, -9.0 * size, 9.0 * size), view);
    add("frustum" + number, ConvexRegion(frustumPlanes(camera)));
    add("narrow frustum" + number,
        ConvexRegion(frustumPlanes(product(perspective(0.01, 0.01 * size, 20.0 * size), view))));
    add("flat frustum" + number, ConvexRegion(frustumPlanes(flat)));
    const Matrix within = product(perspective(1.0, 1e-4 * size, 5.0 * size), viewOf(near, far));
    std::size_t kind = 0;
    for (const Polygon& outline :
         outlines(0.3 * any(random), 0.3 * any(random), 0.3 * std::abs(any(random)), random)) {
      const std::string name = "lasso " + std::to_string(kind++) + number;
      add(name, LassoRegion(outline, camera));
      add(name + " in the mesh", LassoRegion(outline, within));
      add(name + " flat", LassoRegion(outline, flat));
    }
  }
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  for (const double bad : {inf, -inf, nan, 1e300, -1e300, 1e-310}) {
    const std::string name = " of " + std::to_string(bad);
    add("ball at" + name, SphereRegion({bad, 0, 0}, 1.0));
    add("ball with a radius" + name, SphereRegion(middle, bad));
    add("plane with a normal" + name, ConvexRegion({{bad, 0, 0, 1}}));
    add("plane at" + name, ConvexRegion({{0, 1, 0, bad}, {1, 1, 0, size}}));
    add("box with a size" + name, ConvexRegion::box(middle, axes, {1, bad, 1}));
    Matrix camera = product(perspective(0.5, 0.1, 100.0), viewOf({0, 0, 10}, middle));
    add("lasso with a corner" + name, LassoRegion({{bad, 0}, {1, 0}, {0, 1}}, camera));
    camera[5] = bad;
    add("lasso with a matrix" + name, LassoRegion({{-1, -1}, {1, 0}, {0, 1}}, camera));
  }
  add("plane without a normal", ConvexRegion({{0, 0, 0, 1}}));
  add("lasso without a matrix", LassoRegion({{-1, -1}, {1, 0}, {0, 1}}, Matrix{}));
  add("lasso of two corners", LassoRegion({{-1, -1}, {1, 1}}, orthographic(size, -9e9, 9e9)));
  add("lasso of a point", LassoRegion({{0, 0}, {0, 0}, {0, 0}}, orthographic(size, -9e9, 9e9)));
  return regions;
}
