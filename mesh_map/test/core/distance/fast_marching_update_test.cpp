// What a label follows from: monotone in the labels around it, and the least of all ways.

#include "distance/fast_marching/fast_marching_behind.h"
#include "distance/fast_marching/fast_marching_uneven.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace mesh_map {
namespace {

constexpr double ROUNDING = 1e-8;
constexpr int COUNT = 200000;

struct Random
{
  std::mt19937 engine{7};

  double between(double low, double high)
  {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  double scale(double low, double high) { return std::pow(10.0, between(low, high)); }
  /// 0 in half of all cases.
  double some(double most) { return std::max(0.0, between(-most, most)); }

  FastMarchingTriangle triangle()
  {
    const double along = between(-1.5, 2.0), height = scale(-2.0, 0.3);
    return {scale(-1.0, 0.3), along, height, along * along + height * height};
  }
};

double alongEdges(double u, double v, const FastMarchingTriangle& t,
                  const FastMarchingSlowness& slowness)
{
  return std::min(
      u + 0.5 * (slowness.u + slowness.corner) * std::sqrt(t.squared),
      v + 0.5 * (slowness.v + slowness.corner) * std::hypot(t.along - t.base, t.height));
}

TEST(FastMarchingUpdate, HigherLabelsNeverGiveLowerOnes)
{
  Random random;
  for (int i = 0; i < COUNT; ++i) {
    const FastMarchingTriangle t = random.triangle();
    const double u = random.scale(-1.0, 2.0), v = u + t.base * random.between(-1.0, 1.0);
    FastMarchingBehind behind = {random.between(-1.5, 2.0), random.scale(-1.5, 0.3), 0.0};
    const double to_u = std::hypot(behind.along, behind.depth);
    const double to_v = std::hypot(behind.along - t.base, behind.depth);
    behind.label = std::min(u + to_u * random.between(-1.0, 1.0), v + to_v);
    if (v < 0.0 || behind.label < 0.0) {
      continue;
    }
    const auto label = [&](double more_u, double more_v, double more_behind) {
      const FastMarchingBehind later = {behind.along, behind.depth, behind.label + more_behind};
      return std::min(alongEdges(u + more_u, v + more_v, t, {1.0, 1.0, 1.0}),
                      evenUpdate(u + more_u, v + more_v, t, later));
    };
    const double now = label(0.0, 0.0, 0.0);
    const double later = label(random.some(t.base), random.some(t.base), random.some(1.0));
    ASSERT_GE(later, now * (1.0 - ROUNDING)) << i;
  }
}

/// Calls visit(u, v, triangle, slowness, least slowness) for labels that differ by no more than the
/// time along the base.
template <class Visit>
void forEachUneven(double most, const Visit& visit)
{
  Random random;
  for (int i = 0; i < COUNT; ++i) {
    const FastMarchingTriangle t = random.triangle();
    const auto slow = [&]() { return random.between(1.0, most); };
    const FastMarchingSlowness slowness = {slow(), slow(), slow()};
    const double u = random.scale(-1.0, 2.0) * random.between(0.0, 1.0);
    const double time = slowness.onBase() * t.base;
    const double v = std::max(0.0, u + time * random.between(-1.0, 1.0));
    visit(u, v, t, slowness, std::min({slowness.u, slowness.v, slowness.corner}));
  }
}

TEST(FastMarchingUpdate, HigherLabelsNeverGiveLowerOnesWhereCostsChange)
{
  for (const double most : {1.05, 1.3, 3.0, 100.0}) {
    Random random;
    forEachUneven(most, [&](double u, double v, const FastMarchingTriangle& t,
                            const FastMarchingSlowness& slowness, double low) {
      const auto label = [&](double a, double b) {
        FastMarchingUneven ways(a, b, t, slowness, most <= 1.3, low);
        return std::min(alongEdges(a, b, t, slowness), ways.least());
      };
      const double time = slowness.onBase() * t.base;
      const double later = label(u + random.some(time), v + random.some(time));
      ASSERT_GE(later, label(u, v) * (1.0 - ROUNDING));
    });
  }
}

TEST(FastMarchingUpdate, IsTheLeastOfAllWaysOverTheBase)
{
  constexpr int PARTS = 400;
  for (const double most : {1.3, 100.0}) {
    int number = 0, inside = 0;
    forEachUneven(most, [&](double u, double v, const FastMarchingTriangle& t,
                            const FastMarchingSlowness& slowness, double low) {
      const bool round = most <= 1.3;
      const double time = slowness.onBase() * t.base;
      if (number++ % 20 != 0 || (round && (u + v < time || t.height < 0.45 * t.base))) {
        return;
      }
      const double edges = alongEdges(u, v, t, slowness);
      double best = edges;
      for (int i = 0; i <= PARTS; ++i) {
        const double part = static_cast<double>(i) / PARTS;
        const double squared =
            u * u * (1.0 - part) + v * v * part - time * time * part * (1.0 - part);
        const double label =
            round ? std::sqrt(std::max(0.0, squared)) : u * (1.0 - part) + v * part;
        const double slow = 0.5 * (slowness.u * (1.0 - part) + slowness.v * part + slowness.corner);
        best = std::min(best, label + slow * std::hypot(part * t.base - t.along, t.height));
      }
      const double found =
          std::min(edges, FastMarchingUneven(u, v, t, slowness, round, low).least());
      ASSERT_LE(found, best * (1.0 + ROUNDING));
      ASSERT_GE(found, best - 2.0 * most * t.base / PARTS);
      inside += found < edges ? 1 : 0;
    });
    EXPECT_GT(inside, COUNT / 2000);
  }
}

}  // namespace
}  // namespace mesh_map
