// Fast marching from points: exact on planes, good on a sphere, ends on any mesh.

#include <gtest/gtest.h>
#include <mesh_map/front.h>

#include "front_checks.h"

namespace mesh_map {
namespace {

FrontField solve(const SurfaceFront& front, std::vector<std::uint32_t> sources,
                 float max_distance = FAR, std::vector<float> slowness = {})
{
  const std::vector<float> starts(sources.size());
  FrontQuery query;
  query.sources = sources;
  query.source_distances = starts;
  query.max_distance = max_distance;
  query.slowness = slowness;
  return front.solve(query);
}

TEST(SurfaceFront, IsExactOnPlanes)
{
  for (const double jitter : {0.0, 0.24}) {
    const FrontSample sample(plane(60, jitter));
    const SurfaceFront front(sample.front);
    const std::uint32_t source = 20 * 61 + 33;
    const FrontField field = solve(front, {source});
    double worst = 0.0, sum = 0.0;
    for (std::uint32_t v = 0; v < sample.size(); ++v) {
      const double expected = between(sample.mesh, source, v);
      if (expected > 1.0) {
        worst = std::max(worst, std::abs(field.distance[v] / expected - 1.0));
      }
      sum += std::abs(field.distance[v] - expected);
    }
    EXPECT_LT(worst, 1e-3) << jitter;
    EXPECT_LT(sum / sample.size(), 1e-4) << jitter;
  }
}

TEST(SurfaceFront, IsNearGreatCirclesOnASphere)
{
  TestMesh mesh = cube(24);
  for (std::size_t v = 0; v < mesh.positions.size() / 3; ++v) {
    float* const p = &mesh.positions[3 * v];
    const float x = p[0] - 0.5f, y = p[1] - 0.5f, z = p[2] - 0.5f;
    const float length = std::sqrt(x * x + y * y + z * z);
    p[0] = x / length;
    p[1] = y / length;
    p[2] = z / length;
  }
  for (std::uint32_t& corner : mesh.faces) {  // of the six sides, vertices at one place are one
    std::uint32_t first = 0;
    while (between(mesh, first, corner) > 1e-5) {
      ++first;
    }
    corner = first;
  }
  const FrontSample sample(mesh);
  const SurfaceFront front(sample.front);
  const std::uint32_t source = mesh.faces[300];
  const FrontField field = solve(front, {source});
  double sum = 0.0;
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < sample.size(); ++v) {
    const double expected = 2.0 * std::asin(std::min(1.0, 0.5 * between(mesh, source, v)));
    if (field.distance[v] < FAR && expected > 0.6) {
      EXPECT_NEAR(field.distance[v] / expected, 1.0, 0.04) << "vertex " << v;
      sum += std::abs(field.distance[v] / expected - 1.0);
      ++count;
    }
  }
  EXPECT_LT(sum / count, 0.01);
}

TEST(SurfaceFront, EndsOnAnyMesh)
{
  for (const TestMesh& mesh : frontMeshes()) {
    const FrontSample sample(mesh);
    const SurfaceFront front(sample.front);
    const FrontField field = solve(front, {0, static_cast<std::uint32_t>(sample.size() - 1)});
    EXPECT_FALSE(field.cancelled);
    EXPECT_LE(sample.lipschitzExcess(field.distance), 1e-6 * (1.0 + sample.longestEdge()))
        << mesh.name;
    for (std::size_t e = 0; e < sample.topology.edgeCount(); ++e) {
      const bool first = field.distance[sample.topology.edges[2 * e]] < FAR;
      EXPECT_EQ(first, field.distance[sample.topology.edges[2 * e + 1]] < FAR) << mesh.name;
    }
  }
}

TEST(SurfaceFront, StopsAtTheMaximumAndGivesTheSameWithin)
{
  const FrontSample sample(plane(60, 0.24));
  const SurfaceFront front(sample.front);
  const FrontField all = solve(front, {1000, 40}), part = solve(front, {1000, 40}, 1.3f);
  std::size_t reached = 0;
  for (std::size_t v = 0; v < sample.size(); ++v) {
    EXPECT_EQ(part.distance[v], all.distance[v] <= 1.3f ? all.distance[v] : FAR);
    reached += part.distance[v] < FAR;
  }
  EXPECT_GT(reached, 500u);
}

TEST(SurfaceFront, SlownessIsTimePerMeter)
{
  const FrontSample sample(plane(40, 0.2));
  const SurfaceFront front(sample.front);
  const FrontField plain = solve(front, {820});
  const FrontField slow = solve(front, {820}, FAR, std::vector<float>(sample.size(), 3.0f));
  for (std::size_t v = 0; v < sample.size(); ++v) {
    EXPECT_NEAR(slow.distance[v], 3.0 * plain.distance[v], 1e-4);
  }
  // A closed row is not passed, and the way leads round its end.
  std::vector<float> closed(sample.size(), 1.0f);
  for (std::size_t j = 5; j <= 40; ++j) {
    closed[20 * 41 + j] = j % 2 == 0 ? FAR : std::nanf("");
  }
  const std::uint32_t source = 18 * 41 + 30, behind = 22 * 41 + 30;
  const FrontField round = solve(front, {source}, FAR, closed);
  const double way =
      between(sample.mesh, source, 20 * 41 + 4) + between(sample.mesh, 20 * 41 + 4, behind);
  EXPECT_NEAR(round.distance[behind], way, 0.15);
  EXPECT_EQ(round.distance[20 * 41 + 9], FAR);
  EXPECT_EQ(solve(front, {20 * 41 + 10}, FAR, closed).distance[20 * 41 + 10], FAR);
}

TEST(SurfaceFront, RefusesWhatDoesNotFitAndCanBeCancelled)
{
  const FrontSample sample(terrain(5));
  const SurfaceFront front(sample.front);
  EXPECT_THROW(solve(front, {36}), std::invalid_argument);
  EXPECT_THROW(solve(front, {0}, -1.0f), std::invalid_argument);
  EXPECT_THROW(solve(front, {0}, FAR, {1.0f}), std::invalid_argument);
  EXPECT_THROW(solve(front, {0}, FAR, std::vector<float>(36, -1.0f)), std::invalid_argument);
  const std::vector<std::uint32_t> sources{0};
  const std::vector<float> starts{0.0f}, wrong{-1.0f};
  const std::atomic<bool> cancel{true};
  FrontQuery query;
  query.sources = sources;
  query.source_distances = wrong;
  EXPECT_THROW(front.solve(query), std::invalid_argument);
  query.source_distances = starts;
  query.cancel = &cancel;
  EXPECT_TRUE(front.solve(query).cancelled);
}

}  // namespace
}  // namespace mesh_map
