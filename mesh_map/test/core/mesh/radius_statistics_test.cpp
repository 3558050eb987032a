// All ways to find what is around a vertex give the same results, bit for bit.

#include <mesh_map/mesh/topology.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/support/test_meshes.h"
#include "mesh/normals.h"
#include "mesh/radius_statistics.h"

namespace {

using mesh_map::RadiusQuery;
using mesh_map::RadiusSearch;
using mesh_map::RadiusStatistics;

constexpr unsigned ALL = mesh_map::HEIGHT_DIFFERENCE | mesh_map::ROUGHNESS | mesh_map::RIDGE |
                         mesh_map::HEIGHT_DIFFERENCE_AROUND | mesh_map::ROUGHNESS_AROUND |
                         mesh_map::SURFACE_HEIGHT_DIFFERENCE |
                         mesh_map::SURFACE_HEIGHT_DIFFERENCE_AROUND;

struct Sample
{
  explicit Sample(TestMesh of)
      : mesh(std::move(of)),
        topology(mesh_map::buildTopology(mesh.faces, mesh.positions.size() / 3))
  {
    const auto at_faces = mesh_map::faceNormals(mesh.view(), {0, 0, 1});
    normals = mesh_map::vertexNormals({mesh.faces,
                                       at_faces.normals,
                                       {topology.vertex_face_offsets, topology.vertex_faces},
                                       at_faces.without_area,
                                       {},
                                       {0, 0, 1}});
    angles = mesh_map::meanEdgeAngles(normals, topology.edges,
                                      {topology.neighbor_offsets, topology.neighbor_edges});
  }

  RadiusStatistics statistics(double radius, RadiusSearch search, unsigned threads = 1) const
  {
    RadiusQuery query;
    query.positions = mesh.positions;
    query.neighbors = {topology.neighbor_offsets, topology.neighbors};
    query.faces = mesh.faces;
    query.vertex_faces = {topology.vertex_face_offsets, topology.vertex_faces};
    query.angles = angles;
    query.normals = normals;
    query.radius = radius;
    query.wanted = ALL;
    query.search = search;
    query.threads = threads;
    return mesh_map::radiusStatistics(query);
  }

  TestMesh mesh;
  mesh_map::Topology topology;
  std::vector<float> normals, angles;
};

bool sameBits(const std::vector<float>& a, const std::vector<float>& b)
{
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

void expectSame(const RadiusStatistics& a, const RadiusStatistics& b, const std::string& name)
{
  EXPECT_TRUE(sameBits(a.height_differences, b.height_differences)) << name;
  EXPECT_TRUE(sameBits(a.roughnesses, b.roughnesses)) << name;
  EXPECT_TRUE(sameBits(a.ridges, b.ridges)) << name;
  EXPECT_TRUE(sameBits(a.height_differences_around, b.height_differences_around)) << name;
  EXPECT_TRUE(sameBits(a.roughnesses_around, b.roughnesses_around)) << name;
  EXPECT_TRUE(sameBits(a.surface_height_differences, b.surface_height_differences)) << name;
  EXPECT_TRUE(sameBits(a.surface_height_differences_around, b.surface_height_differences_around))
      << name;
}

/// Strips side by side that are connected at one end only: nearer by air than along edges.
TestMesh comb(unsigned teeth, unsigned length)
{
  TestMesh mesh{"comb", {}, {}};
  for (unsigned tooth = 0; tooth < teeth; ++tooth) {
    for (unsigned i = 0; i <= length; ++i) {
      const auto v = static_cast<unsigned>(mesh.positions.size() / 3);
      const float x = 0.1f * tooth, y = 0.11f * i, z = 0.02f * std::sin(5.0f * x + 3.0f * y);
      mesh.positions.insert(mesh.positions.end(), {x, y, z, x + 0.05f, y, z});
      if (i < length) {
        mesh.faces.insert(mesh.faces.end(), {v, v + 1, v + 2, v + 2, v + 1, v + 3});
      }
      if (i == 0 && tooth > 0) {
        const unsigned last = v - 2 * (length + 1);
        mesh.faces.insert(mesh.faces.end(), {last + 1, last, v});
      }
    }
  }
  return mesh;
}

/// Sheets above each other; the lower two share an edge of their border.
TestMesh sheets(unsigned cells)
{
  TestMesh mesh = terrain(cells, 2.0f);
  mesh.name = "sheets";
  const auto count = static_cast<unsigned>(mesh.positions.size() / 3);
  const std::vector<std::uint32_t> faces = mesh.faces;
  for (unsigned sheet = 1; sheet < 3; ++sheet) {
    for (unsigned v = 0; v < count; ++v) {
      for (unsigned axis = 0; axis < 3; ++axis) {
        mesh.positions.push_back(mesh.positions[3 * v + axis] + (axis == 2 ? 0.15f * sheet : 0.0f));
      }
    }
    for (const std::uint32_t v : faces) {
      mesh.faces.push_back(v + sheet * count);
    }
  }
  mesh.faces.insert(mesh.faces.end(), {0, 1, count, count, 1, count + 1});
  return mesh;
}

/// Every vertex is there three times, and edges connect some of these.
TestMesh repeated(unsigned cells)
{
  TestMesh mesh = terrain(cells, 1.0f);
  mesh.name = "repeated";
  const auto count = static_cast<unsigned>(mesh.positions.size() / 3);
  const std::vector<float> positions = mesh.positions;
  for (unsigned copy = 1; copy < 3; ++copy) {
    mesh.positions.insert(mesh.positions.end(), positions.begin(), positions.end());
  }
  for (unsigned v = 0; v + 1 < count; v += 3) {
    mesh.faces.insert(mesh.faces.end(), {v, v + count, v + 1});
    mesh.faces.insert(mesh.faces.end(), {v + 2 * count, v + count, v + 1 + 2 * count});
  }
  return mesh;
}

std::vector<TestMesh> samples()
{
  std::vector<TestMesh> meshes = testMeshes();
  for (const TestMesh& mesh : {comb(12, 9), sheets(12), repeated(12), soup(80, 1.0f)}) {
    meshes.push_back(mesh);
  }
  TestMesh tangle = soup(400, 0.3f);  // few vertices, faces at random: edges all over
  for (std::uint32_t& v : tangle.faces) {
    v = (v * 7919u) % 300u;
  }
  meshes.push_back(tangle);
  return meshes;
}

TEST(RadiusStatistics, GridAndEdgesAgree)
{
  for (const TestMesh& mesh : samples()) {
    const Sample sample(mesh);
    for (const double radius : {0.03, 0.12, 0.3, 0.5, 1.0, 3.0}) {
      if (mesh.positions.size() * radius > 6000.0) {
        continue;  // takes long
      }
      const RadiusStatistics expected = sample.statistics(radius, RadiusSearch::EDGES);
      const std::string name = mesh.name + " within " + std::to_string(radius);
      expectSame(sample.statistics(radius, RadiusSearch::GRID), expected, name);
      expectSame(sample.statistics(radius, RadiusSearch::AUTOMATIC), expected, name);
    }
  }
}

TEST(RadiusStatistics, RadiiAtTheDistanceOfVertices)
{
  const Sample sample(cube(8));  // distances of multiples of 1/8, exact
  for (const double radius : {0.125, 0.25, 0.375, 0.5, 1.0, std::sqrt(2.0) / 8.0}) {
    for (const double limit : {std::nextafter(radius, 0.0), radius, std::nextafter(radius, 9.0)}) {
      expectSame(sample.statistics(limit, RadiusSearch::GRID),
                 sample.statistics(limit, RadiusSearch::EDGES), std::to_string(limit));
    }
  }
}

TEST(RadiusStatistics, AnyRadius)
{
  const Sample sample(terrain(10));
  for (const double radius : {1e-300, 1e-20, 1e-14, 1e4, 1e14, 1e20, 1e300, HUGE_VAL}) {
    expectSame(sample.statistics(radius, RadiusSearch::GRID),
               sample.statistics(radius, RadiusSearch::EDGES), std::to_string(radius));
  }
  TestMesh far = terrain(10);
  for (float& x : far.positions) {
    x *= 1e30f;
  }
  const Sample large(far);
  for (const double radius : {1.0, 1e10}) {
    expectSame(large.statistics(radius, RadiusSearch::GRID),
               large.statistics(radius, RadiusSearch::EDGES), std::to_string(radius));
  }
}

TEST(RadiusStatistics, PositionsThatAreNoNumbers)
{
  const std::vector<float> odd = {std::nanf(""), HUGE_VALF, -HUGE_VALF};
  Sample sample(terrain(10));
  for (std::size_t i = 0; i < sample.mesh.positions.size(); i += 17) {
    sample.mesh.positions[i] = odd[i % 3];
  }
  for (const double radius : {0.3, 1.0}) {
    const RadiusStatistics expected = sample.statistics(radius, RadiusSearch::EDGES);
    expectSame(sample.statistics(radius, RadiusSearch::AUTOMATIC), expected, "automatic");
    expectSame(sample.statistics(radius, RadiusSearch::GRID), expected, "grid");
  }
}

/// Large enough that the search looks for another order.
TEST(RadiusStatistics, VerticesInAnyOrder)
{
  TestMesh mesh = terrain(190, 19.0f);
  const std::size_t count = mesh.positions.size() / 3;
  ASSERT_GT(count, 30'000u);
  constexpr std::size_t step = 7919;
  ASSERT_NE(count % step, 0u);
  const std::vector<float> before = mesh.positions;
  const auto placeOf = [&](std::size_t v) { return v * step % count; };
  for (std::size_t v = 0; v < count; ++v) {
    std::copy_n(before.begin() + static_cast<std::ptrdiff_t>(3 * v), 3,
                mesh.positions.begin() + static_cast<std::ptrdiff_t>(3 * placeOf(v)));
  }
  for (std::uint32_t& v : mesh.faces) {
    v = static_cast<std::uint32_t>(placeOf(v));
  }
  const Sample sample(mesh);
  const RadiusStatistics expected = sample.statistics(0.25, RadiusSearch::EDGES);
  expectSame(sample.statistics(0.25, RadiusSearch::AUTOMATIC), expected, "automatic");
  expectSame(sample.statistics(0.25, RadiusSearch::GRID, 3), expected, "grid");
}

TEST(RadiusStatistics, ThreadsDoNotMatter)
{
  const Sample sample(terrain(60, 6.0f));
  for (const auto search : {RadiusSearch::EDGES, RadiusSearch::GRID}) {
    expectSame(sample.statistics(0.5, search, 3), sample.statistics(0.5, search, 1), "threads");
  }
}

TEST(RadiusStatistics, NothingWantedOrThere)
{
  RadiusQuery query;
  const std::vector<std::uint32_t> offsets = {0};
  query.neighbors.offsets = offsets;
  query.radius = 1.0;
  query.wanted = ALL;
  for (const auto search : {RadiusSearch::AUTOMATIC, RadiusSearch::EDGES, RadiusSearch::GRID}) {
    query.search = search;
    EXPECT_TRUE(mesh_map::radiusStatistics(query).height_differences.empty());
  }
}

}  // namespace
