#include "collision/collision.h"

#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/mesh/topology.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/support/test_meshes.h"
#include "mesh/solids.h"

using namespace mesh_map;

namespace {

/// A box of 12 faces beside what a mesh has; it shares no vertices with that.
void addBox(TestMesh& mesh, const std::array<float, 3>& lower, const std::array<float, 3>& upper)
{
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (unsigned corner = 0; corner < 8; ++corner) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      mesh.positions.push_back((corner >> axis & 1u) != 0 ? upper[axis] : lower[axis]);
    }
  }
  constexpr unsigned sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& side : sides) {
    for (const unsigned k : {0u, 1u, 2u, 0u, 2u, 3u}) {
      mesh.faces.push_back(first + side[k]);
    }
  }
}

/// Rough ground with boxes in it: each third one within another one, some over each other.
TestMesh boxesOnTerrain()
{
  TestMesh mesh = terrain(60);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> place(0.5f, 9.0f), size(0.2f, 1.5f);
  for (unsigned i = 0; i < 40; ++i) {
    const float x = place(random), y = place(random), z = place(random) / 9.0f - 1.0f;
    const float dx = size(random), dy = size(random), dz = size(random);
    addBox(mesh, {x, y, z}, {x + dx, y + dy, z + dz});
    if (i % 3 == 0) {
      addBox(mesh, {x + 0.1f * dx, y + 0.1f * dy, z + 0.1f * dz},
             {x + 0.9f * dx, y + 0.9f * dy, z + 0.9f * dz});
    }
  }
  return mesh;
}

/// A mesh with what collisions() needs.
struct Prepared
{
  explicit Prepared(TestMesh mesh_in)
      : mesh(std::move(mesh_in)),
        topology(buildTopology(mesh.faces, mesh.positions.size() / 3)),
        solids(findSolids(topology.face_edges, topology.face_flags, topology.edgeCount())),
        bvh(Bvh::build(mesh.view()))
  {
    query.mesh = mesh.view();
    query.vertex_faces = {topology.vertex_face_offsets, topology.vertex_faces};
    query.solids = solids;
    query.step_height = 0.1;
    query.robot_height = 0.6;
  }

  TestMesh mesh;
  Topology topology;
  std::vector<std::uint32_t> solids;
  Bvh bvh;
  CollisionQuery query;
};

TEST(Solids, AreClosedPatchesWhateverTouchesThem)
{
  TestMesh mesh = terrain(4);
  const std::size_t ground = mesh.faceCount();
  addBox(mesh, {2.0f, 2.0f, 0.0f}, {3.0f, 3.0f, 1.0f});
  addBox(mesh, {5.0f, 2.0f, 0.0f}, {6.0f, 3.0f, 1.0f});
  addBox(mesh, {7.0f, 2.0f, 0.0f}, {8.0f, 3.0f, 1.0f});
  mesh.faces.resize(mesh.faces.size() - 3);  // the last one is open
  mesh.faces[3 * ground] = mesh.faces[3 * ground + 1] = mesh.faces[3 * ground + 2] = 0;
  addBox(mesh, {7.0f, 5.0f, 0.0f}, {8.0f, 6.0f, 1.0f});
  for (std::uint32_t& corner : mesh.faces) {  // a corner of the second one is one of the ground
    corner = corner == 25 + 8 ? 7 : corner;
  }
  const Prepared made(mesh);
  const auto number = [&](std::size_t face) { return made.solids[face]; };
  for (std::size_t face = 0; face < made.solids.size(); ++face) {
    const std::size_t thing = face < ground ? 9 : (face - ground) / 12;
    const bool closed = thing == 1 || (face >= ground + 35 && thing != 9);
    EXPECT_EQ(number(face), !closed ? NO_INDEX : thing == 1 ? 0u : 1u) << face;
  }
}

TEST(Solids, RefusesEdgesThatDoNotExist)
{
  const Prepared made(terrain(2));
  EXPECT_THROW(findSolids(made.topology.face_edges, made.topology.face_flags, 3),
               std::invalid_argument);
}

TEST(Collision, DoesNotDependOnThreadsOrRooms)
{
  Prepared made(boxesOnTerrain());
  std::vector<float> rooms;
  for (std::size_t v = 0; v < made.query.mesh.vertexCount(); ++v) {
    const float* const at = made.query.mesh.vertex(v);
    const double lift = made.query.step_height;
    const RayHit hit = castRay(made.bvh, {{at[0], at[1], at[2] + lift}, {0.0, 0.0, 1.0}});
    rooms.push_back(static_cast<float>(hit.distance + lift));
  }
  for (const double radius : {0.0, 0.3}) {
    made.query.radius = radius;
    made.query.rooms = {};
    BvhOptions one;
    one.threads = 1;
    const std::vector<std::uint8_t> expected = collisions(made.bvh, made.query, one);
    const auto count = std::count(expected.begin(), expected.end(), 1);
    EXPECT_GT(count, 500);
    EXPECT_LT(count, static_cast<std::ptrdiff_t>(expected.size()) - 500);
    BvhOptions four;
    four.threads = 4;
    EXPECT_EQ(collisions(made.bvh, made.query, four), expected);
    made.query.rooms = rooms;
    EXPECT_EQ(collisions(made.bvh, made.query, four), expected);
  }
}

TEST(Collision, EndsWhenItIsCanceled)
{
  const Prepared made(terrain(20));
  const std::atomic<bool> canceled{true};
  BvhOptions run;
  run.cancel = &canceled;
  EXPECT_THROW(collisions(made.bvh, made.query, run), Canceled);
}

TEST(Collision, RefusesWhatDoesNotFit)
{
  Prepared made(terrain(3));
  const Prepared other(terrain(4));
  const auto refuses = [&](auto change) {
    CollisionQuery query = made.query;
    change(query);
    EXPECT_THROW(collisions(made.bvh, query), std::invalid_argument);
  };
  const std::vector<float> rooms(3, 1.0f);
  const std::vector<std::uint32_t> numbers(made.query.mesh.faceCount(), 1000);
  EXPECT_THROW(collisions(other.bvh, made.query), std::invalid_argument);
  refuses([&](CollisionQuery& query) { query.solids = other.solids; });
  refuses([&](CollisionQuery& query) { query.solids = numbers; });
  refuses([&](CollisionQuery& query) { query.vertex_faces = other.query.vertex_faces; });
  refuses([&](CollisionQuery& query) { query.rooms = rooms; });
  refuses([](CollisionQuery& query) { query.radius = -0.1; });
  refuses([](CollisionQuery& query) { query.radius = std::numeric_limits<double>::infinity(); });
  refuses([](CollisionQuery& query) { query.step_height = -0.1; });
  refuses([](CollisionQuery& query) { query.robot_height = query.step_height; });
  refuses([](CollisionQuery& query) { query.robot_height = query.step_height + 1e-4; });
  EXPECT_EQ(collisions(made.bvh, made.query).size(), made.query.mesh.vertexCount());
}

}  // namespace
