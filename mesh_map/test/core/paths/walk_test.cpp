// Walks over surfaces: straight lines of planes, what is known of a cube, and that any soup of
// triangles is walked on without losing the way. Also with sanitizers.

#include <mesh_map/mesh/topology.h>
#include <mesh_map/paths/walk.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "core/support/test_meshes.h"

namespace {

using mesh_map::NO_INDEX;
using mesh_map::Walk;
using mesh_map::WalkEnd;
using mesh_map::WalkPose;

/// A mesh that can be walked on.
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
};

/// The surface of a cube of edge 1 whose faces share their vertices.
TestMesh weldedCube()
{
  return {"welded cube",
          {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1},
          {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
           1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7}};
}

TestMesh flatTerrain(unsigned cells)
{
  TestMesh mesh = terrain(cells);
  for (std::size_t i = 2; i < mesh.positions.size(); i += 3) {
    mesh.positions[i] = 0.0f;
  }
  return mesh;
}

void checkEnd(const Ground& ground, const Walk& walk, double asked)
{
  ASSERT_LT(walk.pose.face, ground.mesh.faceCount());
  EXPECT_LE(walk.length, std::abs(asked));
  std::array<double, 3> point{};
  double sum = 0.0, along = 0.0, size = 0.0, up = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_GE(walk.pose.barycentric[k], 0.0);
    sum += walk.pose.barycentric[k];
    for (std::size_t i = 0; i < 3; ++i) {
      point[i] += walk.pose.barycentric[k] * ground.mesh.corner(walk.pose.face, k)[i];
    }
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(walk.position[i], point[i], 1e-9 * (1.0 + std::abs(point[i])));
    along += walk.pose.direction[i] * walk.pose.up[i];
    size += walk.pose.direction[i] * walk.pose.direction[i];
    up += walk.pose.up[i] * walk.pose.up[i];
  }
  EXPECT_NEAR(along, 0.0, 1e-7);
  EXPECT_NEAR(size, 1.0, 1e-9);
  EXPECT_NEAR(up, 1.0, 1e-9);
}

TEST(Walk, is_a_straight_line_on_a_plane)
{
  const Ground ground(flatTerrain(40));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::size_t arrived = 0;
  for (int i = 0; i < 500; ++i) {
    WalkPose start;
    start.face = static_cast<std::uint32_t>(unit(random) * ground.mesh.faceCount());
    start.barycentric = {0.5 * unit(random), 0.5 * unit(random), 0.0};
    start.barycentric[2] = 1.0 - start.barycentric[0] - start.barycentric[1];
    const double angle = 6.28 * unit(random), length = 6.0 * unit(random);
    start.direction = {std::cos(angle), std::sin(angle), unit(random)};
    const Walk walk = walkStraight(ground.view(), start, length);
    checkEnd(ground, walk, length);
    const Walk nothing = walkStraight(ground.view(), start, 0.0);
    EXPECT_NEAR(walk.position[0] - nothing.position[0], walk.length * std::cos(angle), 1e-9);
    EXPECT_NEAR(walk.position[1] - nothing.position[1], walk.length * std::sin(angle), 1e-9);
    EXPECT_NEAR(walk.pose.direction[0], std::cos(angle), 1e-9);
    EXPECT_EQ(walk.pose.up[2], 1.0);
    arrived += walk.end == WalkEnd::ARRIVED;
    if (walk.end != WalkEnd::ARRIVED) {
      EXPECT_EQ(walk.end, WalkEnd::BORDER);
      const double x = walk.position[0], y = walk.position[1];
      EXPECT_LT(std::min(std::min(x, 10.0 - x), std::min(y, 10.0 - y)), 1e-9);
    } else {
      EXPECT_EQ(walk.length, length);
    }
  }
  EXPECT_GT(arrived, 100u);
  EXPECT_LT(arrived, 450u);
}

TEST(Walk, goes_round_a_cube_as_unfolded)
{
  const Ground ground(weldedCube());
  WalkPose start;
  start.face = 2;                         // 4 5 6 of the top
  start.barycentric = {0.25, 0.5, 0.25};  // (0.75, 0.25, 1)
  start.direction = {1.0, 0.5, 0.0};
  const double unit = std::sqrt(1.25);
  // over the edge x = 1 and down: x turns into -z
  const Walk down = walkStraight(ground.view(), start, 0.75 * unit);
  EXPECT_NEAR(down.position[0], 1.0, 1e-12);
  EXPECT_NEAR(down.position[1], 0.25 + 0.375, 1e-12);
  EXPECT_NEAR(down.position[2], 0.5, 1e-12);
  EXPECT_NEAR(down.pose.direction[2], -1.0 / unit, 1e-12);
  EXPECT_NEAR(down.pose.up[0], 1.0, 1e-12);
  // along x, 4 edges of 1 m lead back
  start.direction = {1.0, 0.0, 0.0};
  const Walk round = walkStraight(ground.view(), start, 4.0);
  EXPECT_NEAR(round.position[0], 0.75, 1e-12);
  EXPECT_NEAR(round.position[1], 0.25, 1e-12);
  EXPECT_NEAR(round.position[2], 1.0, 1e-12);
  // into the corner (1, 1, 1): 135 degrees on both sides, so down along the edge
  start.barycentric = {0.5, 0.0, 0.5};
  start.direction = {1.0, 1.0, 0.0};
  const Walk corner = walkStraight(ground.view(), start, std::sqrt(0.5) + 0.75);
  EXPECT_NEAR(corner.position[0], 1.0, 1e-12);
  EXPECT_NEAR(corner.position[1], 1.0, 1e-12);
  EXPECT_NEAR(corner.position[2], 0.25, 1e-12);
  EXPECT_NEAR(corner.pose.direction[2], -1.0, 1e-9);
}

TEST(Walk, stays_on_every_mesh)
{
  std::mt19937 random(2);
  std::normal_distribution<double> any(0.0, 1.0);
  mesh_map::WalkOptions options;
  options.max_steps = 2000;
  std::size_t walked = 0;
  std::vector<TestMesh> meshes = testMeshes();
  TestMesh knot{"knot", {}, {}};  // few vertices, edges of many faces, some faces degenerate
  for (int i = 0; i < 30; ++i) {
    knot.positions.push_back(static_cast<float>(any(random)));
  }
  for (int i = 0; i < 240; ++i) {
    knot.faces.push_back(static_cast<std::uint32_t>(random() % 10));
  }
  meshes.push_back(knot);
  meshes.push_back(weldedCube());
  for (const TestMesh& mesh : meshes) {
    const Ground ground(mesh);
    for (int i = 0; i < 200; ++i) {
      WalkPose start;
      start.face = static_cast<std::uint32_t>(random() % mesh.faceCount());
      start.barycentric[random() % 3] = 1.0;  // a corner,
      if (i % 3 > 0) {                        // a point of an edge, or of the face
        start.barycentric = {0.25, 0.75, 0.0};
      }
      if (i % 3 > 1) {
        start.barycentric = {0.25, 0.25, 0.5};
      }
      start.direction = {any(random), any(random), any(random)};
      const double length = i % 7 == 0 ? std::numeric_limits<double>::infinity() : any(random);
      mesh_map::WalkTrace trace;
      const Walk walk = walkStraight(ground.view(), start, length, options, &trace);
      if (walk.end == WalkEnd::NOWHERE) {
        EXPECT_EQ(walk.length, 0.0);
        continue;
      }
      ++walked;
      checkEnd(ground, walk, length);
      EXPECT_EQ(trace.points.size(), 3 * (trace.faces.size() + 1));
      const Walk line =
          walkLine(ground.view(), start, {any(random), any(random), any(random)}, options, &trace);
      EXPECT_GE(line.length, 0.0);
      EXPECT_LT(line.pose.face, mesh.faceCount());
    }
  }
  EXPECT_GT(walked, 1500u);
}

TEST(Walk, refuses_what_is_no_start)
{
  const Ground ground(flatTerrain(4));
  WalkPose start;
  start.face = 0;
  start.barycentric = {0.5, 0.25, 0.25};
  start.direction = {1.0, 0.0, 0.0};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(walkStraight(ground.view(), start, nan).end, WalkEnd::NOWHERE);
  EXPECT_EQ(walkStraight(ground.view(), start, 0.5).end, WalkEnd::ARRIVED);
  for (const std::array<double, 3>& direction :
       {std::array<double, 3>{0, 0, 0}, {0, 0, 1}, {nan, 0, 0}}) {
    WalkPose other = start;
    other.direction = direction;
    EXPECT_EQ(walkStraight(ground.view(), other, 0.5).end, WalkEnd::NOWHERE);
  }
  WalkPose other = start;
  other.face = 32;
  EXPECT_EQ(walkStraight(ground.view(), other, 0.5).end, WalkEnd::NOWHERE);
  EXPECT_EQ(walkLine(ground.view(), other, {1, 1, 0}).end, WalkEnd::NOWHERE);
  EXPECT_EQ(walkLine(ground.view(), start, {1, nan, 0}).end, WalkEnd::NOWHERE);
  const std::vector<std::uint8_t> mask(3, 1);
  mesh_map::WalkOptions options;
  options.mask = mask;
  EXPECT_THROW(walkStraight(ground.view(), start, 1.0, options), std::invalid_argument);
  EXPECT_THROW(walkLine(ground.view(), start, {1, 1, 0}, options), std::invalid_argument);
  EXPECT_THROW(mesh_map::edgeFaces(std::vector<std::uint32_t>{0, 1, 5}, 5), std::invalid_argument);
}

}  // namespace
