// Turning faces so that they agree, and normals of vertices.

#include <mesh_map/mesh/topology.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/support/test_meshes.h"
#include "mesh/normals.h"
#include "mesh/orientation.h"

namespace {

using mesh_map::Orientation;
using mesh_map::Topology;

Orientation orient(const TestMesh& mesh, const std::array<double, 3>& up = {0, 0, 1})
{
  const Topology topology = mesh_map::buildTopology(mesh.faces, mesh.positions.size() / 3);
  return mesh_map::orientFaces(mesh.view(), topology.face_edges, topology.edge_face_counts,
                               topology.edge_flags, up);
}

TestMesh turned(TestMesh mesh, const std::vector<std::uint8_t>& which)
{
  for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
    if (which[f]) {
      std::swap(mesh.faces[3 * f + 1], mesh.faces[3 * f + 2]);
    }
  }
  return mesh;
}

std::vector<std::uint8_t> someOf(std::size_t count)
{
  std::mt19937 random(4);
  std::vector<std::uint8_t> some(count);
  std::generate(some.begin(), some.end(), [&random]() { return random() % 2; });
  return some;
}

std::size_t disagreements(const TestMesh& mesh)
{
  const Topology topology = mesh_map::buildTopology(mesh.faces, mesh.positions.size() / 3);
  return static_cast<std::size_t>(
      std::count_if(topology.edge_flags.begin(), topology.edge_flags.end(),
                    [](auto flags) { return (flags & mesh_map::EDGE_INCONSISTENT) != 0; }));
}

/// Undoes exactly what was done to a mesh that faces up.
TEST(Orientation, TurnsBackWhatWasTurned)
{
  const TestMesh good = terrain(40);  // counter-clockwise from above or below
  const bool down = orient(good).turned[0] != 0;
  EXPECT_EQ(orient(good).turned, std::vector<std::uint8_t>(good.faceCount(), down));
  std::vector<std::uint8_t> expected = someOf(good.faceCount());
  const TestMesh mixed = turned(good, expected);
  for (std::uint8_t& flag : expected) {
    flag ^= static_cast<std::uint8_t>(down);
  }
  const Orientation found = orient(mixed);
  EXPECT_EQ(found.turned, expected);
  EXPECT_EQ(found.patch_count, 1u);
  EXPECT_EQ(found.conflicts, 0u);
  const Orientation below = orient(mixed, {0, 0, -1});
  for (std::size_t f = 0; f < expected.size(); ++f) {
    EXPECT_NE(below.turned[f], expected[f]);
  }
}

TEST(Orientation, AgreesOnAllMeshes)
{
  for (const TestMesh& mesh : testMeshes()) {
    const Orientation found = orient(turned(mesh, someOf(mesh.faceCount())));
    const TestMesh result = turned(turned(mesh, someOf(mesh.faceCount())), found.turned);
    EXPECT_EQ(disagreements(result), found.conflicts) << mesh.name;
    const Orientation again = orient(result);
    EXPECT_EQ(again.conflicts, found.conflicts) << mesh.name;
    EXPECT_EQ(std::count(again.turned.begin(), again.turned.end(), 1), 0) << mesh.name;
  }
}

/// As much of its back as of its front is seen from above: the outside is the front.
TEST(Orientation, ClosedSurfacesFaceOutward)
{
  TestMesh box{"box",
               {0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0, 0, 0, 3, 2, 0, 3, 2, 1, 3, 0, 1, 3},
               {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7}};
  const std::vector<std::uint8_t> some = someOf(box.faceCount());
  EXPECT_EQ(orient(box).turned, std::vector<std::uint8_t>(box.faceCount(), 0));
  EXPECT_EQ(orient(turned(box, some)).turned, some);
}

TEST(Orientation, OneSidedPatchesEndSomehow)
{
  TestMesh strip{"strip", {}, {}};
  constexpr unsigned count = 20;
  for (unsigned i = 0; i < count; ++i) {
    const float angle = 6.2831853f * i / count;
    for (const float side : {-0.3f, 0.3f}) {
      const float r = 1.0f + side * std::cos(angle / 2.0f);
      strip.positions.insert(strip.positions.end(), {r * std::cos(angle), r * std::sin(angle),
                                                     side * std::sin(angle / 2.0f)});
    }
    const unsigned a = 2 * i, b = a + 1;
    const bool last = i + 1 == count;
    const unsigned c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    strip.faces.insert(strip.faces.end(), {a, c, b, b, c, d});
  }
  const Orientation found = orient(strip);
  EXPECT_EQ(found.patch_count, 1u);
  EXPECT_GE(found.conflicts, 1u);
  EXPECT_EQ(disagreements(turned(strip, found.turned)), found.conflicts);
  EXPECT_EQ(orient(strip).turned, found.turned);
}

TEST(Orientation, DegenerateFacesStay)
{
  TestMesh mesh{"odd", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 2, 1, 0, 0, 1, 1, 1, 1}};
  const Orientation found = orient(mesh);
  EXPECT_EQ(found.turned, (std::vector<std::uint8_t>{1, 0, 0}));
  EXPECT_EQ(found.patch_count, 1u);
  EXPECT_EQ(orient(TestMesh{"none", {}, {}}).patch_count, 0u);
}

TEST(Normals, CornerAngles)
{
  TestMesh mesh{
      "right angle", {0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0}, {0, 1, 2, 0, 1, 3, 0, 0, 1, 2, 2, 2}};
  const std::vector<float> angles = mesh_map::cornerAngles(mesh.view());
  const auto pi = static_cast<float>(std::acos(-1.0));
  const float expected[6] = {pi / 2, pi / 4, pi / 4, 0, pi, 0};
  for (unsigned i = 0; i < 6; ++i) {
    EXPECT_NEAR(angles[i], expected[i], 1e-6) << i;
  }
  for (const float angle : angles) {
    EXPECT_TRUE(angle >= 0.0f && angle <= pi);
  }
}

}  // namespace
