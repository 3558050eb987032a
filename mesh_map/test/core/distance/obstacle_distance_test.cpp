// Distances from obstacles: Euclidean on planes, the same however they are found, on any mesh.

#include <gtest/gtest.h>

#include <cstring>

#include "core/support/front_checks.h"
#include "distance/obstacles/obstacle_distance.h"

namespace mesh_map {
namespace {

/// From lethal vertices and edges between them, on a plane.
double euclidean(const FrontSample& sample, const std::vector<std::uint8_t>& lethal, std::size_t v)
{
  double best = FAR;
  for (std::size_t u = 0; u < sample.size(); ++u) {
    best = lethal[u] != 0 ? std::min(best, between(sample.mesh, u, v)) : best;
  }
  const std::vector<float>& p = sample.mesh.positions;
  for (std::size_t e = 0; e < sample.topology.edgeCount(); ++e) {
    const std::size_t a = sample.topology.edges[2 * e], b = sample.topology.edges[2 * e + 1];
    if (lethal[a] != 0 && lethal[b] != 0) {
      const double x = double{p[3 * b]} - p[3 * a], y = double{p[3 * b + 1]} - p[3 * a + 1];
      const double i = double{p[3 * v]} - p[3 * a], j = double{p[3 * v + 1]} - p[3 * a + 1];
      const double t = std::min(1.0, std::max(0.0, (x * i + y * j) / (x * x + y * y)));
      best = std::min(best, std::hypot(i - t * x, j - t * y));
    }
  }
  return best;
}

std::vector<float> distancesOf(const ObstacleDistance& obstacles)
{
  return {obstacles.distances().begin(), obstacles.distances().end()};
}

std::vector<std::array<float, 3>> directionsOf(const ObstacleDistance& obstacles)
{
  std::vector<std::array<float, 3>> found;
  for (std::uint32_t v = 0; v < obstacles.distances().size(); ++v) {
    found.push_back(obstacles.direction(v));
  }
  return found;
}

/// All that can be asked of one, bit for bit.
void expectSame(const ObstacleDistance& found, const ObstacleDistance& expected)
{
  const std::size_t size = expected.distances().size();
  ASSERT_EQ(0, std::memcmp(found.distances().data(), expected.distances().data(), 4 * size));
  ASSERT_EQ(directionsOf(found), directionsOf(expected));
}

TEST(ObstacleDistance, IsEuclideanOnAPlane)
{
  struct Case
  {
    double jitter, share;
  };
  for (const Case& one :
       {Case{0.0, 0.01}, Case{0.24, 0.002}, Case{0.24, 0.02}, Case{0.24, 0.2}, Case{0.24, 0.5}}) {
    const FrontSample sample(plane(60, one.jitter));
    const std::vector<std::uint8_t> lethal = randomMask(sample.size(), one.share, 5);
    ObstacleDistance obstacles(sample.front, 1.0f);
    ASSERT_TRUE(obstacles.compute(lethal));
    std::size_t count = 0;
    for (std::size_t v = 0; v < sample.size(); ++v) {
      const double expected = euclidean(sample, lethal, v), d = obstacles.distances()[v];
      if (expected > 1.0) {
        continue;
      }
      ASSERT_GT(d, expected - 1e-6) << "vertex " << v;
      // Longer only where the outline, which is not straight, is in between.
      const float x = sample.mesh.positions[3 * v], y = sample.mesh.positions[3 * v + 1];
      const bool is_inside = std::min(std::min(x, y), 6.0f - std::max(x, y)) > 1.03f;
      ASSERT_LT(d, expected + (is_inside ? 1e-6 : 0.02)) << "vertex " << v;
      count += is_inside;
    }
    EXPECT_GT(count, 300u);
  }
}

/// From a straight row of edges.
TEST(ObstacleDistance, IsStraightFromAStraightRow)
{
  for (const float jitter : {0.0f, 0.024f}) {
    TestMesh mesh = plane(40, 0.0);
    std::mt19937 random(8);
    std::uniform_real_distribution<float> moved(-jitter, jitter);
    std::vector<std::uint8_t> lethal(mesh.positions.size() / 3);
    for (std::size_t v = 0; v < lethal.size(); ++v) {
      lethal[v] = mesh.positions[3 * v] < 0.55f ? 1 : 0;
      if (lethal[v] == 0) {
        mesh.positions[3 * v] += moved(random);
        mesh.positions[3 * v + 1] += moved(random);
      }
    }
    const FrontSample sample(mesh);
    ObstacleDistance obstacles(sample.front, FAR);
    obstacles.compute(lethal);
    for (std::size_t v = 0; v < sample.size(); ++v) {
      const double x = mesh.positions[3 * v], y = mesh.positions[3 * v + 1];
      const double beyond = std::max(0.0, std::max(-y, y - 4.0));
      const double expected = lethal[v] != 0 ? 0.0 : std::hypot(x - 0.5, beyond);
      const double d = obstacles.distances()[v];
      EXPECT_GT(d, expected - 2e-6) << "vertex " << v;
      const bool is_inside = y > 0.05 && y < 3.95 && x < 3.95;  // of the outline, which is jagged
      EXPECT_LT(d, expected + (is_inside || jitter == 0.0f ? 2e-6 : 0.012)) << "vertex " << v;
      if (lethal[v] == 0 && jitter == 0.0f) {
        EXPECT_NEAR(obstacles.direction(v)[0], 1.0, 1e-5);
      }
    }
  }
}

/// The vertex 2 is as near to the end of the obstacle as to its edge, but 4 is nearer to the edge.
TEST(ObstacleDistance, AnEdgeIsBetterThanItsEnd)
{
  const FrontSample sample(TestMesh{
      "edge", {0, 0, 0, 2, 0, 0, 0, 0.5f, 0, 2, 0.5f, 0, 1, 1, 0}, {0, 1, 2, 2, 1, 3, 2, 3, 4}});
  ObstacleDistance obstacles(sample.front, FAR);
  obstacles.compute(std::vector<std::uint8_t>{1, 1, 0, 0, 0});
  EXPECT_EQ(distancesOf(obstacles), (std::vector<float>{0.0f, 0.0f, 0.5f, 0.5f, 1.0f}));
}

TEST(ObstacleDistance, GrowsNoFasterThanEdgesOnAnyMesh)
{
  for (const TestMesh& mesh : frontMeshes()) {
    const FrontSample sample(mesh);
    for (const double share : {0.02, 0.3}) {
      std::vector<std::uint8_t> lethal = randomMask(sample.size(), share, 2);
      lethal[0] = 1;
      ObstacleDistance obstacles(sample.front, FAR);
      ASSERT_TRUE(obstacles.compute(lethal)) << mesh.name;
      const ArrayView<float> distances = obstacles.distances();
      EXPECT_LE(sample.lipschitzExcess(distances), 2e-7 * (1.0 + sample.longestEdge()))
          << mesh.name;
      for (std::size_t e = 0; e < sample.topology.edgeCount(); ++e) {
        const bool first = distances[sample.topology.edges[2 * e]] < FAR;
        EXPECT_EQ(first, distances[sample.topology.edges[2 * e + 1]] < FAR) << mesh.name;
      }
      for (std::size_t v = 0; v < sample.size(); ++v) {
        ASSERT_EQ(distances[v] == 0.0f, lethal[v] != 0) << mesh.name;
      }
    }
  }
}

/// On a regular plane many pieces of the obstacle are equally near, and the choice has to be one.
TEST(ObstacleDistance, UpdatesAreAsIfComputedAnew)
{
  std::vector<TestMesh> meshes = frontMeshes();
  meshes.push_back(plane(30, 0.0));
  for (const TestMesh& mesh : meshes) {
    const FrontSample sample(mesh);
    const double edge = sample.front->meanEdge();
    for (const double range : {1.5, 6.0}) {
      std::vector<std::uint8_t> lethal = randomMask(sample.size(), 0.05, 3);
      ObstacleDistance updated(sample.front, static_cast<float>(range * edge));
      updated.compute(lethal);
      std::mt19937 random(4);
      for (unsigned round = 0; round < (sample.size() > 1000 ? 4 : 10); ++round) {
        const std::vector<float> before = distancesOf(updated);
        const std::vector<std::array<float, 3>> directions = directionsOf(updated);
        for (unsigned i = 0; i < 1 + round % 3 * 5; ++i) {
          lethal[random() % sample.size()] ^= 1;
        }
        // Around changes only, or, at some point, from everything.
        const double most = round % 4 == 3 ? 0.3 : round % 4 == 2 ? 0.05 : 1.0;
        const std::vector<std::uint32_t> changed = updated.update(lethal, most);
        ObstacleDistance anew(sample.front, static_cast<float>(range * edge));
        anew.compute(lethal);
        ASSERT_NO_FATAL_FAILURE(expectSame(updated, anew)) << mesh.name << " round " << round;
        EXPECT_TRUE(std::is_sorted(changed.begin(), changed.end()));
        for (std::uint32_t v = 0; v < sample.size(); ++v) {
          const bool is_same = updated.distances()[v] == before[v] &&
                               (before[v] == 0.0f || updated.direction(v) == directions[v]);
          EXPECT_TRUE(is_same || std::binary_search(changed.begin(), changed.end(), v));
        }
      }
      EXPECT_TRUE(updated.update(lethal, 1.0).empty());
    }
  }
}

/// Of what is far apart, by turns.
TEST(ObstacleDistance, VeryManyUpdatesAreAsIfComputedAnew)
{
  const FrontSample sample(plane(40, 0.24));
  const auto size = static_cast<std::uint32_t>(sample.size());
  std::vector<std::uint8_t> lethal = randomMask(size, 0.02, 3);
  ObstacleDistance updated(sample.front, 0.3f), anew(sample.front, 0.3f);
  EXPECT_EQ(distancesOf(updated), std::vector<float>(size, FAR));
  updated.compute(lethal);
  std::mt19937 random(4);
  for (unsigned round = 0; round < 1100; ++round) {
    const auto place = static_cast<std::uint32_t>(random() % 80);
    lethal[round % 255 == 0 ? place : size - 1 - place] ^= 1;
    updated.update(lethal, 1.0);
    if (round % 255 < 2) {
      anew.compute(lethal);
      ASSERT_NO_FATAL_FAILURE(expectSame(updated, anew)) << "round " << round;
    }
  }
}

/// Large enough to be divided among threads: the same bits, and what happens where parts meet.
TEST(ObstacleDistance, IsTheSameWithAnyNumberOfThreads)
{
  const FrontSample sample(plane(320, 0.24));
  const std::vector<std::uint8_t> lethal = randomMask(sample.size(), 0.01, 6);
  ObstacleDistance one(sample.front, 0.5f);
  one.compute(lethal, nullptr, 1);
  for (const unsigned threads : {2u, 3u}) {
    ObstacleDistance several(sample.front, 0.5f);
    several.compute(lethal, nullptr, threads);
    ASSERT_NO_FATAL_FAILURE(expectSame(several, one)) << threads;
  }
}

/// An edge between lethal vertices that are far away, along the whole of a mesh in several parts.
TEST(ObstacleDistance, ObstaclesReachIntoOtherParts)
{
  constexpr unsigned CELLS = 320;
  const auto corner = [](std::uint32_t i, std::uint32_t j) { return i * (CELLS + 1) + j; };
  for (const std::uint32_t middle : {90u, 160u, 230u}) {
    TestMesh mesh = plane(CELLS, 0.0);
    const std::uint32_t first = corner(2, 160), last = corner(318, 160), v = corner(middle, 161);
    mesh.faces.insert(mesh.faces.end(), {first, last, v});
    const FrontSample sample(mesh);
    std::vector<std::uint8_t> lethal(sample.size());
    ObstacleDistance updated(sample.front, 0.5f), anew(sample.front, 0.5f);
    for (unsigned i = 0; i <= CELLS; i += 4) {
      lethal[corner(i, 20)] = 1;  // as many in each part
    }
    lethal[last] = 1;
    updated.compute(lethal);
    EXPECT_EQ(updated.distances()[v], FAR);
    lethal[first] = 1;
    updated.update(lethal, 1.0);
    anew.compute(lethal, nullptr, 2);
    EXPECT_NEAR(anew.distances()[v], 0.1, 1e-6);
    EXPECT_NEAR(anew.distances()[v + 3], 0.4, 1e-6);
    ASSERT_NO_FATAL_FAILURE(expectSame(updated, anew));
    lethal[first] = 0;
    updated.update(lethal, 1.0);
    EXPECT_EQ(updated.distances()[v], FAR);
  }
}

/// On the surface of a cube: unfolded across its edges.
TEST(ObstacleDistance, GoesAcrossEdgesOfACube)
{
  TestMesh mesh = cube(8);
  // Vertices of the six sides at the same place are one.
  const std::size_t count = mesh.positions.size() / 3;
  std::vector<std::uint32_t> first(count);
  for (std::uint32_t v = 0; v < count; ++v) {
    first[v] = 0;
    while (between(mesh, first[v], v) > 1e-6) {
      ++first[v];
    }
  }
  for (std::uint32_t& corner : mesh.faces) {
    corner = first[corner];
  }
  const FrontSample sample(mesh);
  std::vector<std::uint8_t> lethal(count);
  std::size_t source = 0;
  while (mesh.positions[3 * source] != 0.5f || mesh.positions[3 * source + 1] != 0.5f ||
         mesh.positions[3 * source + 2] != 1.0f) {
    ++source;
  }
  lethal[first[source]] = 1;
  ObstacleDistance obstacles(sample.front, FAR);
  obstacles.compute(lethal);
  for (std::uint32_t v = 0; v < count; ++v) {
    const float x = mesh.positions[3 * v], y = mesh.positions[3 * v + 1],
                z = mesh.positions[3 * v + 2];
    if (first[v] == v && x == 1.0f && z > 0.0f) {  // the side next to the top
      const double over_edge = std::hypot(0.5 + (1.0 - z), y - 0.5);
      const double round_corner = std::hypot(0.5 + (1.0 - y), 0.5 + (1.0 - z));
      const double round_other = std::hypot(0.5 + y, 0.5 + (1.0 - z));
      const double expected = std::min({over_edge, round_corner, round_other});
      EXPECT_NEAR(obstacles.distances()[v], expected, 1e-5) << y << " " << z;
    }
  }
}

/// Behind a slit in a plane the way goes round its ends.
TEST(ObstacleDistance, GoesRoundHoles)
{
  TestMesh mesh = plane(40, 0.2);
  std::vector<std::uint32_t> kept;
  const unsigned row = 41;
  for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
    const std::size_t i = f / 2 / 40, j = f / 2 % 40;
    const bool is_slit = i == 20 && j >= 10 && j < 30;
    if (!is_slit) {
      kept.insert(kept.end(), &mesh.faces[3 * f], &mesh.faces[3 * f] + 3);
    }
  }
  mesh.faces = kept;
  const FrontSample sample(mesh);
  std::vector<std::uint8_t> lethal(sample.size());
  const std::uint32_t source = 15 * row + 20;
  lethal[source] = 1;
  ObstacleDistance obstacles(sample.front, FAR);
  obstacles.compute(lethal);
  const auto corner = [&](std::uint32_t i, std::uint32_t j) { return i * row + j; };
  std::size_t behind = 0;
  for (std::uint32_t j = 12; j < 29; ++j) {
    for (std::uint32_t i = 22; i < 26; ++i) {
      const std::uint32_t v = corner(i, j);
      double expected = FAR;
      for (const std::uint32_t end : {10u, 30u}) {
        const double near = between(sample.mesh, source, corner(20, end));
        expected =
            std::min(expected, near + between(sample.mesh, corner(20, end), corner(21, end)) +
                                   between(sample.mesh, corner(21, end), v));
      }
      const double straight = between(sample.mesh, source, v);
      if (expected > straight + 0.3) {
        ++behind;
        EXPECT_LT(obstacles.distances()[v], expected + 0.05) << i << " " << j;
        EXPECT_GT(obstacles.distances()[v], expected - 0.15) << i << " " << j;
      }
    }
  }
  EXPECT_GT(behind, 20u);
}

TEST(ObstacleDistance, WithoutObstaclesNothingIsReached)
{
  const FrontSample sample(terrain(5));
  ObstacleDistance obstacles(sample.front, 1.0f);
  std::vector<std::uint8_t> lethal(sample.size());
  ASSERT_TRUE(obstacles.compute(lethal));
  EXPECT_EQ(distancesOf(obstacles), std::vector<float>(sample.size(), FAR));
  EXPECT_EQ(obstacles.direction(3), (std::array<float, 3>{}));
  lethal.assign(sample.size(), 1);
  obstacles.update(lethal, 1.0);
  EXPECT_EQ(distancesOf(obstacles), std::vector<float>(sample.size(), 0.0f));
}

TEST(ObstacleDistance, ManyEqualTrianglesAreNoTrouble)
{
  const FrontSample sample(identical(100000));
  ObstacleDistance obstacles(sample.front, FAR);
  obstacles.compute(std::vector<std::uint8_t>{1, 0, 0});
  EXPECT_EQ(distancesOf(obstacles), (std::vector<float>{0.0f, 1.0f, 1.0f}));
}

/// Nor is a vertex with very many different faces, which a quadratic effort would show.
TEST(ObstacleDistance, AHubIsNoTrouble)
{
  constexpr unsigned COUNT = 50000;
  TestMesh mesh{"hub", {0.0f, 0.0f, 0.0f}, {}};
  for (unsigned i = 0; i < COUNT; ++i) {
    const double angle = 6.283185307179586 * i / COUNT;
    mesh.positions.insert(mesh.positions.end(), {static_cast<float>(std::cos(angle)),
                                                 static_cast<float>(std::sin(angle)), 0.0f});
    mesh.faces.insert(mesh.faces.end(), {0u, i + 1, (i + 1) % COUNT + 1});
  }
  const FrontSample sample(mesh);
  std::vector<std::uint8_t> lethal(COUNT + 1);
  ObstacleDistance obstacles(sample.front, FAR);
  lethal[0] = 1;
  obstacles.compute(lethal);
  EXPECT_NEAR(obstacles.distances()[77], 1.0, 1e-6);
  lethal[0] = 0;
  lethal[1] = 1;
  obstacles.update(lethal, 1.0);
  EXPECT_NEAR(obstacles.distances()[0], 1.0, 1e-6);
  EXPECT_NEAR(obstacles.distances()[1 + COUNT / 2], 2.0, 1e-3);
}

/// A floor over the same vertices again, divided the other way: behind each edge there are twice as
/// many ways of the same length.
TEST(ObstacleDistance, SheetsOnEachOtherAreNoTrouble)
{
  for (const unsigned sheets : {2u, 5u}) {
    TestMesh mesh = plane(40, 0.0, 1);
    for (unsigned sheet = 1; sheet < sheets; ++sheet) {
      const TestMesh other = plane(40, 0.0, sheet + 1);
      mesh.faces.insert(mesh.faces.end(), other.faces.begin(), other.faces.end());
    }
    const FrontSample sample(mesh);
    std::vector<std::uint8_t> lethal(sample.size());
    lethal[20 * 41 + 20] = lethal[20 * 41 + 21] = lethal[7] = 1;
    ObstacleDistance obstacles(sample.front, FAR);
    ASSERT_TRUE(obstacles.compute(lethal));
    for (std::size_t v = 0; v < sample.size(); ++v) {
      EXPECT_NEAR(obstacles.distances()[v], euclidean(sample, lethal, v), 2e-6) << v;
    }
  }
}

/// ... nor where they lie near to each other only: none of the ways are equal.
TEST(ObstacleDistance, RoughSheetsOnEachOtherAreNoTrouble)
{
  constexpr unsigned CELLS = 30;
  for (const unsigned sheets : {2u, 5u}) {
    TestMesh mesh = plane(CELLS, 0.0, 1);
    for (unsigned sheet = 1; sheet < sheets; ++sheet) {
      const TestMesh other = plane(CELLS, 0.0, sheet + 1);
      mesh.faces.insert(mesh.faces.end(), other.faces.begin(), other.faces.end());
    }
    std::mt19937 random(2);
    std::uniform_real_distribution<float> raised(-0.002f, 0.002f);
    for (std::size_t v = 0; v < mesh.positions.size() / 3; ++v) {
      mesh.positions[3 * v + 2] = raised(random);
    }
    const FrontSample sample(mesh);
    std::vector<std::uint8_t> lethal(sample.size());
    lethal[15 * (CELLS + 1) + 15] = lethal[7] = 1;
    ObstacleDistance obstacles(sample.front, FAR);
    ASSERT_TRUE(obstacles.compute(lethal));
    for (std::size_t v = 0; v < sample.size(); ++v) {
      const double d = obstacles.distances()[v], flat = euclidean(sample, lethal, v);
      EXPECT_GT(d, flat - 1e-6) << v;
      EXPECT_LT(d, 1.001 * flat + 1e-6) << v;
    }
  }
}

/// Faces without area, around which a window would go forever.
TEST(ObstacleDistance, FacesWithoutAreaAreNoTrouble)
{
  for (unsigned seed = 0; seed < 60; ++seed) {
    TestMesh mesh = tangle(30, 200, seed);
    std::mt19937 random(seed);
    for (std::size_t v = 1; v < 30; ++v) {  // on a few places of one line, or of a plane
      mesh.positions[3 * v] = static_cast<float>(random() % 4);
      mesh.positions[3 * v + 1] = seed % 2 == 0 ? 0.0f : static_cast<float>(random() % 3);
      mesh.positions[3 * v + 2] = 0.0f;
    }
    const FrontSample sample(mesh);
    std::vector<std::uint8_t> lethal(sample.size());
    lethal[mesh.faces[0]] = lethal[mesh.faces[1]] = 1;
    ObstacleDistance obstacles(sample.front, FAR);
    ASSERT_TRUE(obstacles.compute(lethal));
    EXPECT_LE(sample.lipschitzExcess(obstacles.distances()), 1e-6) << seed;
    const float before = obstacles.distances()[3];
    lethal[5] ^= 1;
    obstacles.update(lethal, 1.0);
    lethal[5] ^= 1;
    obstacles.update(lethal, 1.0);
    EXPECT_EQ(obstacles.distances()[3], before);
  }
}

/// Many of them between two parts of a plane, which are the only way.
TEST(ObstacleDistance, WaysGoOnBehindManyFacesWithoutArea)
{
  constexpr unsigned CELLS = 200;
  TestMesh mesh = plane(CELLS, 0.0, 3);
  for (std::size_t v = 0; v < mesh.positions.size() / 3; ++v) {  // 180 columns are one
    const auto column = static_cast<unsigned>(v / (CELLS + 1));
    const unsigned place = column < 10 ? column : column > 190 ? column - 180 : 10;
    mesh.positions[3 * v] = 0.1f * static_cast<float>(place);
  }
  const FrontSample sample(mesh);
  std::vector<std::uint8_t> lethal(sample.size());
  lethal[3 * (CELLS + 1) + 50] = 1;
  ObstacleDistance obstacles(sample.front, 3.0f);
  ASSERT_TRUE(obstacles.compute(lethal));
  for (std::size_t v = 191 * (CELLS + 1); v < sample.size(); ++v) {
    const double expected = euclidean(sample, lethal, v);
    if (expected < 2.99) {
      EXPECT_NEAR(obstacles.distances()[v], expected, 2e-6) << v;
    }
  }
}

/// Close behind a very long edge, where the direction of what comes over it is not known exactly:
/// at the corner of a border the way bends by next to nothing.
TEST(ObstacleDistance, WaysBendBehindLongEdges)
{
  for (int i = -20; i <= 20; ++i) {
    const float side = 0.013f * static_cast<float>(i);
    // The source, the ends of the long edge, the corner, two beyond it, and the one behind these.
    const float y = -side - 4e-4f;
    const FrontSample sample(TestMesh{"long edge",
                                      {-10, side, 0, -0.01f, -1000, 0, -0.01f, 1000, 0, 0, 0, 0,  //
                                       5,   2,    0, 5,      -2,    0, 10,     y,    0},
                                      {0, 1, 2, 1, 3, 2, 3, 4, 2, 3, 5, 4, 5, 6, 4}});
    ObstacleDistance obstacles(sample.front, FAR);
    obstacles.compute(std::vector<std::uint8_t>{1, 0, 0, 0, 0, 0, 0});
    const double bent = std::hypot(10.0, double{side}) + std::hypot(10.0, double{y});
    EXPECT_NEAR(obstacles.distances()[6], bent, 4e-6) << side;
  }
}

TEST(ObstacleDistance, EndsWhenCancelled)
{
  const FrontSample sample(plane(150, 0.2));
  const std::vector<std::uint8_t> lethal = randomMask(sample.size(), 0.01, 1);
  ObstacleDistance obstacles(sample.front, 1.0f), expected(sample.front, 1.0f);
  const std::atomic<bool> cancel{true};
  EXPECT_FALSE(obstacles.compute(lethal, &cancel));
  expected.compute(lethal);
  EXPECT_EQ(obstacles.update(lethal, 1.0).size(), sample.size());
  expectSame(obstacles, expected);
}

TEST(ObstacleDistance, RefusesWhatDoesNotFit)
{
  const FrontSample sample(terrain(5));
  EXPECT_THROW(ObstacleDistance(sample.front, 0.0f), std::invalid_argument);
  EXPECT_THROW(ObstacleDistance(sample.front, std::nanf("")), std::invalid_argument);
  ObstacleDistance obstacles(sample.front, 1.0f);
  EXPECT_THROW(obstacles.compute(std::vector<std::uint8_t>(3)), std::invalid_argument);
  EXPECT_THROW(obstacles.update(std::vector<std::uint8_t>(3)), std::invalid_argument);
}

}  // namespace
}  // namespace mesh_map
