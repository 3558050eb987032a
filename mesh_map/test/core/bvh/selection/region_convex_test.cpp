#include "region_triangles.h"

using namespace mesh_map;

namespace {

const double INF = std::numeric_limits<double>::infinity();
const std::array<Vector, 3> AXES{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
const ConvexRegion CUBE = ConvexRegion::box({0, 0, 0}, AXES, {1, 1, 1});

Depth depthIn(const ConvexRegion& region)
{
  return [&region](const Vector& p) {
    double least = INF;
    for (const Plane& plane : region.planes()) {
      least = std::min(least, plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3]);
    }
    return least;
  };
}

ConvexRegion anyRegion(std::mt19937& random)
{
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Vector way{any(random), any(random), any(random)};
  const Vector place{any(random), any(random), any(random)};
  switch (random() % 4) {
    case 0:
      return ConvexRegion::box(place, axesAlong(way), {std::abs(any(random)), 0.3, 0.1});
    case 1:
      return ConvexRegion(frustumPlanes(
          product(perspective(0.3, 0.1, 3.0), viewOf({3.0 * way[0], 3.0 * way[1], 2.0}, place))));
    case 2: {
      std::vector<Plane> planes;  // perhaps without anything in common
      for (int i = 0; i < 10; ++i) {
        planes.push_back({any(random), any(random), any(random), any(random) + 0.4});
      }
      return ConvexRegion(planes);
    }
    default:
      return CUBE;
  }
}

}  // namespace

TEST(ConvexRegion, isTrueOfThePointsOfTriangles)
{
  std::mt19937 random(2);
  std::array<int, 3> said{};
  for (int i = 0; i < 12000; ++i) {
    const ConvexRegion region = anyRegion(random);
    const Depth depth = depthIn(region);
    const Triangle triangle = anyTriangle(random);
    const Side side = check(region, triangle, depth, 1e-11);
    ++said[static_cast<std::size_t>(side)];
    if (i % 20 == 0) {
      const double most = deepest(triangle, depth);
      EXPECT_FALSE(side == Side::OUTSIDE && most > 1e-6) << most;
      EXPECT_FALSE(side != Side::OUTSIDE && most < -1e-6) << most;
    }
  }
  EXPECT_GT(*std::min_element(said.begin(), said.end()), 300);
}

TEST(ConvexRegion, touchesInPointsAndAlongEdges)
{
  struct Case
  {
    const char* name;
    Triangle triangle;
    Side side;
  };
  const Case cases[] = {
      {"a corner in a corner", {1, 1, 1, 2, 2, 2, 2, 3, 2}, Side::TOUCHING},
      {"a corner beyond a corner", {1.0000001f, 1, 1, 2, 2, 2, 2, 3, 2}, Side::OUTSIDE},
      {"an edge through an edge", {0, 2, 0, 2, 0, 0, 3, 3, 0}, Side::TOUCHING},
      {"an edge through an edge by thirds",
       {0.7f, 1.3f, 0, 1.3f, 0.7f, 0, 3, 3, 0},
       Side::TOUCHING},
      {"an edge just past an edge", {0, 2.000001f, 0, 2, 0, 0, 3, 3, 0}, Side::OUTSIDE},
      {"a face on a face", {1, -9, -9, 1, 9, -9, 1, 0, 9}, Side::TOUCHING},
      {"a face within a face", {1, 0, 0, 1, 1, 0, 1, 0, 1}, Side::INSIDE},
      {"a corner in a face", {1, 0.3f, 0.2f, 2, 0, 0, 2, 1, 0}, Side::TOUCHING},
      {"a plane through a corner", {3, 0, 0, 0, 3, 0, 0, 0, 3}, Side::TOUCHING},
      {"a plane past a corner", {3.00001f, 0, 0, 0, 3, 0, 0, 0, 3}, Side::OUTSIDE},
      {"all around", {-9, -9, 0, 9, -9, 0, 0, 20, 0}, Side::TOUCHING},
      {"as large as the cube", {-1, -1, -1, 1, 1, -1, 1, 1, 1}, Side::INSIDE},
      {"the point of a corner", {1, 1, 1, 1, 1, 1, 1, 1, 1}, Side::INSIDE},
      {"a point beyond", {1, 1, 1.0001f, 1, 1, 1.0001f, 1, 1, 1.0001f}, Side::OUTSIDE},
      {"a segment through", {-2, 0, 0, 2, 0, 0, 0, 0, 0}, Side::TOUCHING},
      {"a segment through, thrice a point but one", {-2, 0, 0, -2, 0, 0, 2, 0, 0}, Side::TOUCHING},
      {"a segment past a corner", {3, 0, 0, 0, 3, 0, 1.5f, 1.5f, 0}, Side::OUTSIDE},
  };
  for (const Case& one : cases) {
    EXPECT_EQ(CUBE.triangle(one.triangle.data()), one.side) << one.name;
    check(CUBE, one.triangle, depthIn(CUBE), 1e-12);
  }
}

TEST(ConvexRegion, touchesInAPointHoweverItIsTurned)
{
  // The middle of an edge of the triangle is on an edge of the wedge: no number is exact here.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int touches = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::array<Vector, 3> axes = axesAlong({any(random), any(random), any(random)});
    Triangle triangle{0.5f, 1.5f, 0.0f, 1.5f, 0.5f, 0.0f, 4.0f, 4.0f, 0.0f};
    triangle[2] = static_cast<float>(any(random));
    triangle[5] = static_cast<float>(any(random));
    const Vector touched = pointOf(triangle, 0.5, 0.0);
    const Vector edge{1.0, -1.0, double{triangle[5]} - triangle[2]};
    std::vector<Plane> planes;
    bool steep = true;  // where an edge runs along a plane, it is nowhere sure where they meet
    for (const Vector& side : {axes[0], axes[1]}) {
      const double sign = side[0] + side[1] < 0.0 ? 1.0 : -1.0;
      planes.push_back(
          {sign * side[0], sign * side[1], sign * side[2], -sign * dot(side, touched)});
      steep = steep && std::abs(dot(side, edge)) > 0.05;
    }
    if (steep) {
      ASSERT_EQ(ConvexRegion(planes).triangle(triangle.data()), Side::TOUCHING);
      ++touches;
    }
  }
  EXPECT_GT(touches, 2000);
}

TEST(ConvexRegion, containsNothingIfInvalid)
{
  const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::vector<Plane> bad{{INF, 0, 0, 1},
                               {0, std::nan(""), 0, 1},
                               {0, 0, 1, INF},
                               {0, 0, 0, 1},
                               {1, 1, 1, std::nan("")}};
  for (const Plane& plane : bad) {
    const ConvexRegion region({{1, 0, 0, 5}, plane});
    EXPECT_FALSE(region.valid());
    EXPECT_EQ(region.triangle(corners), Side::OUTSIDE);
    EXPECT_FALSE(region.contains({0, 0, 0}));
  }
  for (const double size : {-1e-9, INF, -INF, std::nan("")}) {
    EXPECT_EQ(ConvexRegion::box({0, 0, 0}, AXES, {1, size, 1}).triangle(corners), Side::OUTSIDE);
  }
  EXPECT_EQ(ConvexRegion::box({0, 0, 0}, AXES, {0, 0, 0}).triangle(corners), Side::TOUCHING);
  EXPECT_THROW(ConvexRegion({}), std::invalid_argument);
  EXPECT_THROW(ConvexRegion(std::vector<Plane>(17, Plane{1, 0, 0, 0})), std::invalid_argument);
  EXPECT_NO_THROW(ConvexRegion(std::vector<Plane>(16, Plane{1, 0, 0, 0})));
}

TEST(ConvexRegion, isRightForHugeAndTinyNumbers)
{
  const float corners[] = {2, 0, 0, 3, 0, 0, 2, 1, 0};
  EXPECT_EQ(ConvexRegion({{1e300, 1e300, 0, -1e300}}).triangle(corners), Side::INSIDE);
  EXPECT_EQ(ConvexRegion({{1e-310, 0, 0, -2.5e-310}}).triangle(corners), Side::TOUCHING);
  EXPECT_EQ(ConvexRegion({{1e-310, 0, 0, 1e300}}).triangle(corners), Side::INSIDE);
  EXPECT_EQ(ConvexRegion({{1e-310, 0, 0, -1e300}}).triangle(corners), Side::OUTSIDE);
  const float largest = std::numeric_limits<float>::max();
  const float huge[] = {-largest, -largest, 0, largest, 0, 0, 0, largest, 0};
  EXPECT_EQ(CUBE.triangle(huge), Side::TOUCHING);
}

TEST(ConvexRegion, asksOnlyThePlanesThatMayCut)
{
  std::mt19937 random(5);
  for (int i = 0; i < 5000; ++i) {
    const ConvexRegion region = anyRegion(random);
    const Triangle triangle = anyTriangle(random);
    std::uint32_t cutting = 0;
    for (std::size_t p = 0; p < region.planes().size(); ++p) {
      const Plane& plane = region.planes()[p];
      for (std::size_t k = 0; k < 9; k += 3) {
        const bool behind = plane[0] * triangle[k] + plane[1] * triangle[k + 1] +
                                plane[2] * triangle[k + 2] + plane[3] <
                            0.0;
        cutting |= behind ? 1u << p : 0u;
      }
    }
    ASSERT_EQ(region.triangle(triangle.data(), cutting), region.triangle(triangle.data()));
  }
}
