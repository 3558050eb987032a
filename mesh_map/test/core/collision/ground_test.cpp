#include "collision/ground.h"

#include <mesh_map/mesh/topology.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "core/support/test_meshes.h"

using namespace mesh_map;

namespace {

/// A strip of squares of 1 m along x, cut in two: square i is between x = i and i + 1, its faces
/// are 2 i and 2 i + 1, its first corners vertices 2 i (y = 0) and 2 i + 1. `heights` are of its
/// edges.
TestMesh strip(const std::vector<float>& heights)
{
  TestMesh mesh;
  for (std::uint32_t i = 0; i < heights.size(); ++i) {
    for (const float y : {0.0f, 1.0f}) {
      mesh.positions.insert(mesh.positions.end(), {static_cast<float>(i), y, heights[i]});
    }
    const std::uint32_t a = 2 * i;
    if (i + 1 < heights.size()) {
      mesh.faces.insert(mesh.faces.end(), {a, a + 2, a + 1, a + 1, a + 2, a + 3});
    }
  }
  return mesh;
}

/// Whether a face is ground for a body at a vertex.
struct Asked
{
  explicit Asked(TestMesh mesh_in)
      : mesh(std::move(mesh_in)),
        topology(buildTopology(mesh.faces, mesh.positions.size() / 3)),
        covered(mesh.faceCount(), HAS_CELLS),
        closed(mesh.positions.size() / 3, 0)
  {
  }

  bool isGround(std::uint32_t vertex, std::uint32_t face, double radius)
  {
    Ground ground(mesh.view(), {topology.vertex_face_offsets, topology.vertex_faces}, covered,
                  closed, 0.2);
    bool answer = false;
    for (const double some : {0.1, 100.0, radius}) {  // nothing is left of what was asked before
      const VertexBand body(mesh.view().vertex(vertex), {0.2, 1.0}, some);
      ground.begin(vertex, body);
      ground.want(face);
      ground.want(face);
      answer = ground.hasAllWanted();
    }
    return answer;
  }

  TestMesh mesh;
  Topology topology;
  std::vector<std::uint8_t> covered, closed;
};

TEST(Ground, IsLowAndWithinTheRadius)
{
  Asked level(strip({0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f}));
  EXPECT_TRUE(level.isGround(0, 6, 3.1));   // begins at x = 3
  EXPECT_FALSE(level.isGround(0, 6, 2.9));  // also a face is near whose corners all are not
  EXPECT_TRUE(level.isGround(0, 1, 0.9));
  EXPECT_FALSE(level.isGround(0, 3, 0.9));
  Asked slope(strip({0.0f, 1.1f, 2.1f, 3.1f, 4.3f, 4.3f}));  // up to 0.2 m and the distance
  EXPECT_TRUE(slope.isGround(0, 4, 9.0));
  EXPECT_FALSE(slope.isGround(0, 6, 9.0));
  EXPECT_FALSE(slope.isGround(0, 8, 9.0));  // it is low, but nothing low leads there
  EXPECT_TRUE(slope.isGround(8, 0, 9.0));   // downhill everything is low
}

TEST(Ground, LeadsOntoFacesWithoutCellsFromOpenVerticesAlone)
{
  Asked asked(strip({0.0f, 0.0f, 0.0f, 0.0f, 0.0f}));
  asked.covered[2] = asked.covered[3] = 0;
  EXPECT_TRUE(asked.isGround(0, 4, 9.0));
  asked.closed[2] = asked.closed[3] = 1;
  EXPECT_FALSE(asked.isGround(0, 2, 9.0));
  EXPECT_FALSE(asked.isGround(0, 4, 9.0));
  EXPECT_TRUE(asked.isGround(0, 0, 9.0));
}

TEST(Ground, SurfacesAreWhatFacesJoin)
{
  TestMesh mesh = strip({0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f});
  mesh.faces = {9, 7, 5, 5, 0, 4, 3, 8, 6, 10, 10, 2};
  EXPECT_EQ(surfacesOf(mesh.view()),
            (std::vector<std::uint32_t>{0, 1, 2, 3, 0, 0, 3, 0, 3, 0, 2, 11}));
}

}  // namespace
