// What counts for a closest point: ties, storeys, normals, limits, and what is not a question.
#include "closest_checks.h"

using mesh_map::Bvh;
using mesh_map::ClosestOptions;
using mesh_map::NO_INDEX;

namespace {

/// A floor at height 0 (looking up), and a ceiling at 2.5 (looking down) with its other side, the
/// next floor, at 2.75 (looking up); each 2 x 2 faces of 10 m.
TestMesh storeys()
{
  TestMesh mesh{"storeys", {}, {}};
  for (const float height : {2.5f, 0.0f, 2.75f}) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
    for (unsigned i = 0; i < 9; ++i) {
      const auto x = static_cast<float>(i / 3), y = static_cast<float>(i % 3);
      mesh.positions.insert(mesh.positions.end(), {10 * x - 10, 10 * y - 10, height});
    }
    for (const std::uint32_t v : {0u, 1u, 3u, 4u}) {
      const std::uint32_t a = first + v, b = a + 3, c = a + 1, d = a + 4;
      if (height == 2.5f) {
        mesh.faces.insert(mesh.faces.end(), {a, c, b, c, d, b});
      } else {
        mesh.faces.insert(mesh.faces.end(), {a, b, c, c, b, d});
      }
    }
  }
  return mesh;
}

double heightOf(const Bvh& bvh, const Point& point, const ClosestOptions& options = {})
{
  const mesh_map::SurfaceHit hit = closestPoint(bvh, point.data(), options);
  return hit.face == NO_INDEX ? -1.0 : hit.position[2];
}

TEST(ClosestPointFilter, FindsTheFloorOfARobotBelowACeiling)
{
  const Bvh bvh = Bvh::build(storeys().view());
  const Point head = {1.0, 2.0, 1.75}, upstairs = {1.0, 2.0, 2.625};
  const std::vector<double> up = {0.0, 0.0, 2.0}, down = {0.0, 0.0, -1e-5}, tilted = {0.1, 0.0, 1};
  ClosestOptions options;
  EXPECT_EQ(heightOf(bvh, head), 2.5);
  options.max_angle = 0.5;
  options.normals = up;
  EXPECT_EQ(heightOf(bvh, head, options), 2.75);
  options.max_distance = 1.75;  // the height of the robot: what is above it is no floor of it
  EXPECT_EQ(heightOf(bvh, {1.0, 2.0, 1.25}, options), 0.0);
  options.max_distance = std::nextafter(1.25, 0.0);
  EXPECT_EQ(heightOf(bvh, {1.0, 2.0, 1.25}, options), -1.0);
  options.max_distance = INFINITY;
  options.normals = tilted;
  EXPECT_EQ(heightOf(bvh, {1.0, 2.0, 1.25}, options), 0.0);
  options.max_angle = 0.09;  // atan(0.1) = 0.0997
  EXPECT_EQ(heightOf(bvh, {1.0, 2.0, 1.25}, options), -1.0);
  options.normals = down;
  EXPECT_EQ(heightOf(bvh, {1.0, 2.0, 0.5}, options), 2.5);
  options.normals = up;
  EXPECT_EQ(heightOf(bvh, upstairs, options), 2.75);
}

TEST(ClosestPointFilter, NamesTheFirstOfFacesAsNear)
{
  const TestMesh mesh = storeys();
  const Bvh bvh = Bvh::build(mesh.view());
  // as far from both storeys, and from edges and corners of several faces of each
  for (const Point& point : {Point{0, 0, 1.25}, Point{-10, -10, 1.25}, Point{3, 0, 1.25},
                             Point{0, 0, 2.625}, Point{4, 4, 1.25}}) {
    expectSame(closestPoint(bvh, point.data()), lookAtEveryFace(mesh, point), text(point));
    EXPECT_LT(closestPoint(bvh, point.data()).face, 8u);  // of the ceiling, which comes first
  }
  const Bvh same = Bvh::build(identical(3000).view());
  std::vector<std::uint8_t> mask(3000, 1);
  ClosestOptions options;
  options.mask = mask;
  const Point point = {0.2, 0.2, 5.0};
  for (std::uint32_t first = 0; first < 3000; first += 271) {
    std::fill(mask.begin(), mask.begin() + first, 0);
    EXPECT_EQ(closestPoint(same, point.data(), options).face, first);
  }
  std::fill(mask.begin(), mask.end(), 0);
  EXPECT_EQ(closestPoint(same, point.data(), options).face, NO_INDEX);
}

TEST(ClosestPointFilter, FindsNothingForWhatIsNotFinite)
{
  const Bvh bvh = Bvh::build(terrain(5).view());
  const Point good = {1.0, 2.0, 3.0};
  for (const double bad : {NAN, INFINITY, -INFINITY}) {
    for (std::size_t i = 0; i < 3; ++i) {
      Point point = good;
      point[i] = bad;
      EXPECT_EQ(closestPoint(bvh, point.data()).face, NO_INDEX);
      std::vector<double> normal = {0.0, 0.0, 1.0};
      normal[i] = bad;
      ClosestOptions options;
      options.normals = normal;
      EXPECT_EQ(closestPoint(bvh, good.data(), options).face, NO_INDEX);
    }
  }
  for (const double bad : {double{NAN}, -1.0, -5e-324, -double{INFINITY}}) {
    ClosestOptions options;
    options.max_distance = bad;
    const mesh_map::SurfaceHit hit = closestPoint(bvh, good.data(), options);
    EXPECT_EQ(hit.face, NO_INDEX);
    EXPECT_EQ(hit.distance, INFINITY);
    EXPECT_EQ(hit.position, Point{});
    EXPECT_EQ(hit.barycentric, Point{});
  }
  const std::vector<double> none = {0.0, -0.0, 0.0}, up = {0.0, 0.0, 1.0};
  ClosestOptions options;
  options.normals = none;
  EXPECT_EQ(closestPoint(bvh, good.data(), options).face, NO_INDEX);
  options.normals = up;
  for (const double bad : {double{NAN}, -0.1, -double{INFINITY}}) {
    options.max_angle = bad;
    EXPECT_EQ(closestPoint(bvh, good.data(), options).face, NO_INDEX);
    options.normals = {};  // nobody asks for the angle
    EXPECT_NE(closestPoint(bvh, good.data(), options).face, NO_INDEX);
    options.normals = up;
  }
}

TEST(ClosestPointFilter, RefusesArraysThatDoNotFit)
{
  const Bvh bvh = Bvh::build(terrain(5).view());
  const std::vector<double> points(6), four(4);
  const std::vector<std::uint8_t> mask(49);
  const auto refusal = [&](mesh_map::ArrayView<double> at, const ClosestOptions& options) {
    try {
      closestPoints(bvh, at, options);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  ClosestOptions options;
  EXPECT_EQ(refusal(points, options), "");
  EXPECT_EQ(refusal(four, options), "points of 4 numbers: 3 for each point");
  options.normals = four;
  EXPECT_EQ(refusal(points, options),
            "normals of 4 numbers: 3 for each of 2 points, 3 for all, or none");
  EXPECT_THROW(closestPoint(bvh, points.data(), options), std::invalid_argument);
  options.normals = {};
  options.mask = mask;
  EXPECT_EQ(refusal(points, options), "a mask of 49 numbers: one for each of 50 faces, or none");
}

TEST(NormalWithin, IsTheAngleBetweenNormalAndDirection)
{
  const std::vector<float> floor = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const double degrees : {0.0, 1e-6, 0.001, 1.0, 45.0, 89.999, 90.0, 91.0, 179.0, 179.9999}) {
    const double angle = degrees * M_PI / 180;
    for (const double around : {0.0, 1.0, 4.0}) {
      const Point direction = {std::sin(angle) * std::cos(around),
                               std::sin(angle) * std::sin(around), std::cos(angle)};
      EXPECT_TRUE(normalWithin(floor.data(), direction, angle + 1e-11)) << degrees;
      EXPECT_TRUE(normalWithin(floor.data(), direction, angle)) << degrees;
      EXPECT_FALSE(normalWithin(floor.data(), direction, angle - 1e-11)) << degrees;
      EXPECT_TRUE(normalWithin(floor.data(), direction, M_PI)) << degrees;
    }
  }
}

TEST(NormalWithin, CountsFacesInTheirOwnDirectionAtAnyScale)
{
  const TestMesh mesh = soup(200);
  for (const float scale : {1e-18f, 1.0f, 1e18f}) {
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
      std::vector<float> corners = mesh.corners(f);
      for (float& x : corners) {
        x *= scale;
      }
      long double u[3], v[3];
      for (std::size_t i = 0; i < 3; ++i) {
        u[i] = corners[3 + i] - static_cast<long double>(corners[i]);
        v[i] = corners[6 + i] - static_cast<long double>(corners[i]);
      }
      const long double n[] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                               u[0] * v[1] - u[1] * v[0]};
      const long double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      Point direction;
      for (std::size_t i = 0; i < 3; ++i) {
        direction[i] = static_cast<double>(n[i] / length);
      }
      EXPECT_TRUE(normalWithin(corners.data(), direction, 0.0)) << f;
      for (double& x : direction) {
        x = -x;
      }
      EXPECT_FALSE(normalWithin(corners.data(), direction, 3.1)) << f;
    }
  }
}

TEST(NormalWithin, LeavesOutFacesWithoutAreaUnlessAllCount)
{
  const std::vector<float> segment = {0, 0, 0, 1, 1, 1, 2, 2, 2},
                           floor = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const Point up = {0.0, 0.0, 1.0}, none = {0.0, 0.0, NAN};
  EXPECT_FALSE(normalWithin(segment.data(), up, std::nextafter(M_PI, 0.0)));
  EXPECT_TRUE(normalWithin(segment.data(), up, M_PI));
  EXPECT_TRUE(normalWithin(segment.data(), up, INFINITY));
  EXPECT_FALSE(normalWithin(floor.data(), up, NAN));
  EXPECT_FALSE(normalWithin(floor.data(), up, -1e-13));
  EXPECT_FALSE(normalWithin(floor.data(), none, M_PI));
}

}  // namespace
