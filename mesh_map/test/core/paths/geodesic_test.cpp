// Paths pulled taut: straight on planes, known ways over a cube, and that any soup of triangles
// gives a valid path that is no longer. Also with sanitizers.

#include <mesh_map/mesh/topology.h>
#include <mesh_map/paths/geodesic.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <vector>

#include "core/support/test_meshes.h"

namespace {

using mesh_map::Geodesic;
using mesh_map::GeodesicOptions;
using mesh_map::WalkTrace;

struct Ground
{
  TestMesh mesh;
  mesh_map::Topology topology;
  mesh_map::EdgeFaces rows;

  explicit Ground(TestMesh of)
      : mesh(std::move(of)),
        topology(mesh_map::buildTopology(mesh.faces, mesh.positions.size() / 3)),
        rows(mesh_map::edgeFaces(topology.face_edges, topology.edgeCount()))
  {
  }

  mesh_map::WalkMesh view() const
  {
    return {mesh.view(),
            topology.face_edges,
            topology.face_flags,
            rows.rows(),
            {topology.vertex_face_offsets, topology.vertex_faces}};
  }

  bool isDegenerate(std::size_t face) const
  {
    return (topology.face_flags[face] & mesh_map::FACE_DEGENERATE) != 0;
  }

  void addPoint(WalkTrace& path, std::size_t face, const double* weights) const
  {
    for (std::size_t i = 0; i < 3; ++i) {
      double sum = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        sum += weights[k] * mesh.corner(face, k)[i];
      }
      path.points.push_back(sum);
    }
  }
};

double lengthOf(const WalkTrace& path)
{
  double sum = 0.0;
  for (std::size_t i = 0; i < path.faces.size(); ++i) {
    double square = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double step = path.points[3 * i + 3 + k] - path.points[3 * i + k];
      square += step * step;
    }
    sum += std::sqrt(square);
  }
  return sum;
}

double distanceOfEnds(const WalkTrace& path)
{
  const std::size_t last = path.points.size() - 3;
  return lengthOf({{path.points[0], path.points[1], path.points[2], path.points[last],
                    path.points[last + 1], path.points[last + 2]},
                   {0}});
}

/// From face to face over random edges, at random places, sometimes at their ends.
WalkTrace randomWay(const Ground& ground, std::mt19937& random, std::size_t steps)
{
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::uint32_t face;
  do {
    face = static_cast<std::uint32_t>(random() % ground.mesh.faceCount());
  } while (ground.isDegenerate(face));
  const double inside[] = {0.2, 0.3, 0.5};
  WalkTrace path;
  ground.addPoint(path, face, inside);
  for (std::size_t i = 0; i < steps; ++i) {
    const std::size_t k = random() % 3;
    const double share = random() % 3 == 0 ? 1.0 : unit(random);
    double weights[3] = {};
    weights[k] = 1.0 - share;
    weights[(k + 1) % 3] = share;
    ground.addPoint(path, face, weights);
    path.faces.push_back(face);
    const std::uint32_t edge = ground.topology.face_edges[3 * face + k];
    const std::uint32_t begin = ground.rows.offsets[edge], end = ground.rows.offsets[edge + 1];
    face = ground.rows.faces[begin + random() % (end - begin)];
  }
  ground.addPoint(path, face, inside);
  path.faces.push_back(face);
  return path;
}

TEST(Geodesic, is_straight_on_a_plane)
{
  TestMesh mesh = terrain(30);
  for (std::size_t i = 2; i < mesh.positions.size(); i += 3) {
    mesh.positions[i] = 0.0f;
  }
  const Ground ground(mesh);
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const WalkTrace given = randomWay(ground, random, trial);
    const Geodesic found = shortenPath(ground.view(), given);
    EXPECT_TRUE(found.settled);
    EXPECT_NEAR(found.length, distanceOfEnds(given), 1e-12);  // the plane is convex
  }
}

TEST(Geodesic, of_a_cube_is_straight_when_unfolded)
{
  const Ground ground({"welded cube",
                       {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1},
                       {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                        1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7}});
  // from the middle of the top to the middle of the side x = 1, by a corner
  const WalkTrace given{{0.5, 0.5, 1.0, 1.0, 0.0, 1.0, 1.0, 0.5, 0.5}, {2, 7}};
  const Geodesic near = shortenPath(ground.view(), given);
  EXPECT_NEAR(near.length, 1.0, 1e-12);
  // through the side y = 0: nothing near it is shorter, but what is beyond the corner
  const WalkTrace around{
      {0.5, 0.5, 1.0, 0.5, 0.0, 1.0, 0.5, 0.0, 0.5, 1.0, 0.0, 0.5, 1.0, 0.3, 0.6}, {2, 5, 4, 7}};
  EXPECT_NEAR(shortenPath(ground.view(), around).length, std::hypot(0.8, 0.9), 1e-12);
  GeodesicOptions options;
  options.over_hills = true;
  const Geodesic over = shortenPath(ground.view(), around, options);
  EXPECT_NEAR(over.length, std::hypot(0.5 + 0.4, 0.2), 1e-12);
  EXPECT_EQ(over.path.faces, (std::vector<std::uint32_t>{2, 7}));
}

TEST(Geodesic, of_any_soup_is_no_longer_and_valid)
{
  std::mt19937 random(7);
  for (const TestMesh& mesh : testMeshes()) {
    const Ground ground(mesh);
    for (int trial = 0; trial < 40; ++trial) {
      const WalkTrace given = randomWay(ground, random, trial);
      const Geodesic found = shortenPath(ground.view(), given);
      EXPECT_TRUE(found.settled) << mesh.name;
      EXPECT_LE(found.length, lengthOf(given)) << mesh.name;
      EXPECT_DOUBLE_EQ(found.length, lengthOf(found.path));
      EXPECT_EQ(found.path.points.size(), 3 * found.path.faces.size() + 3);
      EXPECT_TRUE(
          std::equal(given.points.begin(), given.points.begin() + 3, found.path.points.begin()));
      EXPECT_TRUE(
          std::equal(given.points.end() - 3, given.points.end(), found.path.points.end() - 3) ||
          found.path.faces.empty());
      // accepted, that is in its faces; and nothing is left to gain
      const Geodesic again = shortenPath(ground.view(), found.path);
      EXPECT_NEAR(again.length, found.length, 1e-9 * found.length) << mesh.name;
      GeodesicOptions options;
      options.over_hills = true;
      const Geodesic over = shortenPath(ground.view(), given, options);
      EXPECT_LE(over.length, found.length * (1.0 + 1e-12)) << mesh.name;
      shortenPath(ground.view(), over.path);  // accepted, too
    }
  }
}

TEST(Geodesic, enters_only_faces_that_count)
{
  const Ground ground(terrain(20));
  std::mt19937 random(3);
  std::size_t bent = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const WalkTrace given = randomWay(ground, random, 80);
    std::vector<std::uint8_t> mask(ground.mesh.faceCount(), 0);
    for (const std::uint32_t face : given.faces) {
      mask[face] = 1;
    }
    GeodesicOptions options;
    options.mask = mask;
    const Geodesic found = shortenPath(ground.view(), given, options);
    for (const std::uint32_t face : found.path.faces) {
      EXPECT_EQ(mask[face], 1);
    }
    EXPECT_LE(found.length, lengthOf(given));
    bent += found.length > shortenPath(ground.view(), given).length * (1.0 + 1e-9);
  }
  EXPECT_GT(bent, 10u);
}

TEST(Geodesic, goes_around_a_hub_of_many_faces)
{
  constexpr unsigned COUNT = 20000;
  TestMesh fan{"fan", {0, 0, 0}, {}};
  for (unsigned i = 0; i < COUNT; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / COUNT;
    fan.positions.insert(fan.positions.end(), {static_cast<float>(std::cos(angle)),
                                               static_cast<float>(std::sin(angle)), 0.0f});
    fan.faces.insert(fan.faces.end(), {0, 1 + i, 1 + (i + 1) % COUNT});
  }
  const Ground ground(fan);
  WalkTrace given;
  const double middle[] = {0.5, 0.25, 0.25}, edge[] = {0.5, 0.0, 0.5};
  ground.addPoint(given, 0, middle);
  for (unsigned i = 0; i < COUNT / 3; ++i) {
    given.faces.push_back(i);
    ground.addPoint(given, i, edge);
  }
  const Geodesic found = shortenPath(ground.view(), given);
  EXPECT_NEAR(found.length, distanceOfEnds(given), 1e-9);
  // more than half way round, through the hub: the other side is shorter
  WalkTrace through;
  ground.addPoint(through, 0, middle);
  through.faces = {0, 2 * COUNT / 3};
  const double hub[] = {1.0, 0.0, 0.0};
  ground.addPoint(through, 0, hub);
  ground.addPoint(through, 2 * COUNT / 3, middle);
  EXPECT_NEAR(shortenPath(ground.view(), through).length, distanceOfEnds(through), 1e-9);
}

TEST(Geodesic, refuses_what_is_no_path)
{
  const Ground ground(terrain(3));
  const std::vector<double> start = {0, 0, 0};
  EXPECT_THROW(shortenPath(ground.view(), {start, {0}}), std::invalid_argument);
  EXPECT_THROW(shortenPath(ground.view(), {{0, 0, 0, 1, NAN, 0}, {0}}), std::invalid_argument);
  EXPECT_THROW(shortenPath(ground.view(), {{0, 0, 0, 9, 9, 9}, {0}}), std::invalid_argument);
  EXPECT_THROW(shortenPath(ground.view(), {{0, 0, 0, 0, 0, 0}, {99}}), std::invalid_argument);
  const std::vector<std::uint8_t> short_mask(2, 1);
  GeodesicOptions options;
  options.mask = short_mask;
  EXPECT_THROW(shortenPath(ground.view(), {start, {}}, options), std::invalid_argument);
  EXPECT_EQ(shortenPath(ground.view(), {start, {}}).path.points, start);
}

}  // namespace
