// closestPointOnTriangle() against a search in 80-bit floats that knows nothing of feet and edges.
#include <algorithm>

#include "closest_checks.h"

using Real = long double;

namespace {

struct Triangle
{
  std::array<Real, 3> a, u, v;

  explicit Triangle(const std::vector<float>& corners)
  {
    for (std::size_t i = 0; i < 3; ++i) {
      a[i] = corners[i];
      u[i] = Real{corners[3 + i]} - a[i];
      v[i] = Real{corners[6 + i]} - a[i];
    }
  }

  /// Least distance to the points a + beta u + gamma v with this gamma.
  Real acrossAt(const Point& point, Real gamma) const
  {
    Real along = 0, length = 0, squared = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      along += (point[i] - a[i] - gamma * v[i]) * u[i];
      length += u[i] * u[i];
    }
    const Real beta = length > 0 ? std::min(1 - gamma, std::max(Real{0}, along / length)) : 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Real gap = point[i] - a[i] - gamma * v[i] - beta * u[i];
      squared += gap * gap;
    }
    return std::sqrt(squared);
  }

  /// The distance is convex, so that two points in an interval say where it is least.
  Real distance(const Point& point) const
  {
    Real low = 0, high = 1, least = std::min(acrossAt(point, 0), acrossAt(point, 1));
    for (int i = 0; i < 160; ++i) {
      const Real left = low + (high - low) / 3, right = high - (high - low) / 3;
      const Real at_left = acrossAt(point, left), at_right = acrossAt(point, right);
      least = std::min({least, at_left, at_right});
      (at_left < at_right ? high : low) = at_left < at_right ? right : left;
    }
    return least;
  }

  Real size() const
  {
    Real result = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      result = std::max({result, std::abs(u[i]), std::abs(v[i])});
    }
    return result;
  }
};

mesh_map::SurfaceHit nearest(const std::vector<float>& corners, const Point& point)
{
  return mesh_map::closestPointOnTriangle(&corners[0], &corners[3], &corners[6], point.data());
}

void checkTriangle(const std::vector<float>& corners, const Point& point)
{
  const Triangle triangle(corners);
  const mesh_map::SurfaceHit hit = nearest(corners, point);
  const Real distance = triangle.distance(point);
  // A needle's foot is as uncertain as its normal. Roundings of a far point's differences count,
  // too.
  const Real tolerance = 1e-12L * triangle.size() + 1e-15L * distance;
  EXPECT_LE(std::abs(hit.distance - distance), tolerance) << text(point);

  Real squared = 0, largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GE(hit.barycentric[i], -1e-15);
    EXPECT_LE(hit.barycentric[i], 1.0);
    const Real mixed = hit.barycentric[0] * Real{corners[i]} +
                       hit.barycentric[1] * Real{corners[3 + i]} +
                       hit.barycentric[2] * Real{corners[6 + i]};
    const Real scale =
        std::max({std::abs(corners[i]), std::abs(corners[3 + i]), std::abs(corners[6 + i])});
    largest = std::max(largest, scale);
    EXPECT_LE(std::abs(hit.position[i] - mixed), 1e-15L * scale);
    const Real gap = point[i] - Real{hit.position[i]};
    squared += gap * gap;
  }
  EXPECT_NEAR(hit.barycentric[0] + hit.barycentric[1] + hit.barycentric[2], 1.0, 1e-15);
  EXPECT_LE(std::abs(std::sqrt(squared) - hit.distance), 1e-15L * (largest + distance));
}

TEST(ClosestPointOnTriangle, IsTheNearestOfAll)
{
  for (const TestMesh& mesh : testMeshes()) {
    std::mt19937 random(6);
    std::normal_distribution<double> any(0.0, 1.0);
    SCOPED_TRACE(mesh.name);
    for (std::size_t f = 0; f < mesh.faceCount(); f += 1 + mesh.faceCount() / 60) {
      const std::vector<float> corners = mesh.corners(f);
      const Real size = Triangle(corners).size();
      for (const double away : {1e-6, 0.3, 3.0, 1e4}) {
        Point point;
        for (std::size_t i = 0; i < 3; ++i) {
          point[i] = corners[i] + static_cast<double>(size) * away * any(random);
        }
        checkTriangle(corners, point);
      }
    }
  }
}

TEST(ClosestPointOnTriangle, KnowsEachCornerEdgeAndSide)
{
  const std::vector<float> corners = {0, 0, 0, 4, 0, 0, 0, 4, 0};
  const struct
  {
    Point point, position;
    double distance;
  } cases[] = {
      {{1, 1, 0}, {1, 1, 0}, 0.0},     {{1, 1, 3}, {1, 1, 0}, 3.0},  {{1, 1, -3}, {1, 1, 0}, 3.0},
      {{2, -3, 4}, {2, 0, 0}, 5.0},    {{-3, 2, 4}, {0, 2, 0}, 5.0}, {{5, 5, 0}, {2, 2, 0}, 18.0},
      {{-3, -4, 12}, {0, 0, 0}, 13.0}, {{7, -4, 0}, {4, 0, 0}, 5.0}, {{-4, 7, 0}, {0, 4, 0}, 5.0},
      {{2, 2, 0}, {2, 2, 0}, 0.0},     {{4, 0, 1}, {4, 0, 0}, 1.0},  {{0, 4, 1}, {0, 4, 0}, 1.0},
  };
  for (const auto& row : cases) {
    const mesh_map::SurfaceHit hit = nearest(corners, row.point);
    EXPECT_EQ(hit.position, row.position) << text(row.point);
    EXPECT_EQ(hit.distance, row.distance == 18.0 ? std::sqrt(18.0) : row.distance);
    EXPECT_EQ(hit.barycentric[1], hit.position[0] / 4);
    EXPECT_EQ(hit.barycentric[2], hit.position[1] / 4);
  }
}

TEST(ClosestPointOnTriangle, TakesOneWithoutAreaForTheSegmentOrPointThatItIs)
{
  const Point point = {1, 2, 0};
  const std::array<float, 3> ends[] = {{0, 0, 0}, {3, 0, 0}};
  for (unsigned which = 0; which < 8; ++which) {  // each corner at either end
    std::vector<float> corners;
    for (unsigned k = 0; k < 3; ++k) {
      const auto& end = ends[(which >> k) & 1u];
      corners.insert(corners.end(), end.begin(), end.end());
    }
    const mesh_map::SurfaceHit hit = nearest(corners, point);
    const Point expected = {which == 0 ? 0.0 : which == 7 ? 3.0 : 1.0, 0.0, 0.0};
    EXPECT_LE(std::abs(hit.position[0] - expected[0]), 1e-15) << which;
    EXPECT_DOUBLE_EQ(hit.distance, std::hypot(1 - expected[0], 2.0)) << which;
  }
}

TEST(ClosestPointOnTriangle, HasAFiniteDistanceToEveryPointThereIs)
{
  const std::vector<float> corners = {-3e38f, 0, 0, 3e38f, 0, 0, 0, 3e38f, 1};
  for (const double x : {1e60, 1e139, 0.99e140, 1e140, 1.01e140, 1e155, 1e200, 1.7e308}) {
    EXPECT_DOUBLE_EQ(nearest(corners, {0, 0, -x}).distance, x);
    EXPECT_DOUBLE_EQ(nearest(corners, {0.3 * x, 0.4 * x, 0}).distance, 0.5 * x);
    EXPECT_DOUBLE_EQ(nearest(corners, {x / 2, x / 2, x / 2}).distance, x * std::sqrt(0.75)) << x;
  }
}

}  // namespace
