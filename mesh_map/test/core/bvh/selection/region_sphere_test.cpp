#include "region_triangles.h"

using namespace mesh_map;

namespace {

const double INF = std::numeric_limits<double>::infinity();

/// Distances of float numbers to the left of 3 and 4, from 5: exact in squares and root.
const Triangle AT_DISTANCE_5{3, 4, 0, 3, 4, 7, 6, 8, 0};

}  // namespace

TEST(SphereRegion, isTrueOfThePointsOfTriangles)
{
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1.5, 1.5);
  std::array<int, 3> said{};
  for (int i = 0; i < 20000; ++i) {
    const Vector center{any(random), any(random), any(random)};
    const double radius = std::pow(10.0, any(random) - 0.5);
    const Depth depth = [&](const Vector& p) {
      return radius - std::sqrt(std::pow(p[0] - center[0], 2) + std::pow(p[1] - center[1], 2) +
                                std::pow(p[2] - center[2], 2));
    };
    const Triangle triangle = anyTriangle(random);
    const Side side = check(SphereRegion(center, radius), triangle, depth, 1e-12);
    ++said[static_cast<std::size_t>(side)];
    if (i % 20 == 0) {
      const double most = deepest(triangle, depth);
      EXPECT_FALSE(side == Side::OUTSIDE && most > 1e-6) << most;
      EXPECT_FALSE(side != Side::OUTSIDE && most < -1e-6) << most;
    }
  }
  EXPECT_GT(*std::min_element(said.begin(), said.end()), 500);
}

TEST(SphereRegion, touchesExactly)
{
  const float* const corners = AT_DISTANCE_5.data();
  EXPECT_EQ(SphereRegion({0, 0, 0}, 5.0).triangle(corners), Side::TOUCHING);
  EXPECT_EQ(SphereRegion({0, 0, 0}, std::nextafter(5.0, 0.0)).triangle(corners), Side::OUTSIDE);
  EXPECT_EQ(SphereRegion({0, 0, 0}, 10.0).triangle(corners), Side::INSIDE);
  EXPECT_EQ(SphereRegion({0, 0, 0}, std::nextafter(10.0, 0.0)).triangle(corners), Side::TOUCHING);
  EXPECT_EQ(SphereRegion({3, 4, 7}, 0.0).triangle(corners), Side::TOUCHING);
  EXPECT_EQ(SphereRegion({3, 4, 3}, 0.0).triangle(corners), Side::TOUCHING);  // on an edge
  const float face[] = {0, 0, 5, 9, 0, 5, 0, 9, 5};
  EXPECT_EQ(SphereRegion({1, 1, 0}, 5.0).triangle(face), Side::TOUCHING);
  EXPECT_EQ(SphereRegion({1, 1, 0}, 4.999999).triangle(face), Side::OUTSIDE);
  const float point[] = {1, 2, 3, 1, 2, 3, 1, 2, 3};
  EXPECT_EQ(SphereRegion({1, 2, 3}, 0.0).triangle(point), Side::INSIDE);
  EXPECT_EQ(SphereRegion({1, 2, 4}, 1.0).triangle(point), Side::INSIDE);
}

TEST(SphereRegion, containsNothingIfInvalid)
{
  const float* const corners = AT_DISTANCE_5.data();
  for (const double bad : {INF, -INF, std::nan(""), -1.0, -1e-300}) {
    const SphereRegion sphere({3, 4, 0}, bad);
    EXPECT_FALSE(sphere.valid());
    EXPECT_EQ(sphere.triangle(corners), Side::OUTSIDE);
    EXPECT_FALSE(sphere.contains({3, 4, 0}));
  }
  for (const double bad : {INF, -INF, std::nan("")}) {
    EXPECT_EQ(SphereRegion({3, bad, 0}, 1e9).triangle(corners), Side::OUTSIDE);
  }
}

TEST(SphereRegion, isRightForHugeNumbers)
{
  const float* const corners = AT_DISTANCE_5.data();
  for (const double far : {1e40, 1e150, 1e200, 1e307}) {
    for (const Vector& center : {Vector{far, 0, 0}, Vector{0, -far, 0}}) {
      EXPECT_EQ(SphereRegion(center, 0.99 * far).triangle(corners), Side::OUTSIDE) << far;
      EXPECT_EQ(SphereRegion(center, 1.01 * far).triangle(corners), Side::INSIDE) << far;
    }
    EXPECT_EQ(SphereRegion({0, 0, 0}, far).triangle(corners), Side::INSIDE);
  }
  const float largest = std::numeric_limits<float>::max();
  const float huge[] = {-largest, -largest, 1, largest, 0, 1, 0, largest, 1};
  EXPECT_EQ(SphereRegion({0, 0, 0}, 2.0).triangle(huge), Side::TOUCHING);
  EXPECT_EQ(SphereRegion({0, 0, 0}, 1e39).triangle(huge), Side::INSIDE);
}
