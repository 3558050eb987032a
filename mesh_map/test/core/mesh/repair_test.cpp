// Meshes with holes and faults: mended by any number of threads alike, whatever the mesh.

#include <mesh_map/mesh/topology.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/support/test_meshes.h"
#include "mesh/repair/hole_filling.h"
#include "mesh/repair/manifold.h"
#include "mesh/repair/simplification.h"

namespace {

using mesh_map::HoleFilling;
using mesh_map::HoleLimits;
using mesh_map::ManifoldMesh;
using mesh_map::MeshView;
using mesh_map::Topology;

/// A mesh without some of its faces, so that it has holes, and some that touch.
TestMesh holed(TestMesh mesh, unsigned seed)
{
  std::mt19937 random(seed);
  std::vector<std::uint32_t> faces;
  for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
    if (random() % 8 != 0) {
      faces.insert(faces.end(), mesh.faces.begin() + std::ptrdiff_t(3 * face),
                   mesh.faces.begin() + std::ptrdiff_t(3 * face + 3));
    }
  }
  mesh.faces = faces;
  return mesh;
}

/// Faces among few vertices: degenerate and duplicate ones, and edges of many faces.
TestMesh tangle(unsigned seed)
{
  std::mt19937 random(seed);
  TestMesh mesh = terrain(2);
  const auto vertices = static_cast<unsigned>(mesh.positions.size() / 3);
  mesh.faces.resize(90);
  std::generate(mesh.faces.begin(), mesh.faces.end(), [&]() { return random() % vertices; });
  return mesh;
}

std::size_t countOf(const std::vector<std::uint8_t>& flags, std::uint8_t flag)
{
  return static_cast<std::size_t>(std::count_if(
      flags.begin(), flags.end(), [flag](std::uint8_t value) { return (value & flag) != 0; }));
}

HoleLimits allHoles()
{
  HoleLimits limits;
  limits.perimeter = 1e9;
  limits.flatness = 1e9;
  return limits;
}

TEST(Repair, FillsHolesAlikeWithAnyNumberOfThreads)
{
  for (unsigned seed = 0; seed < 5; ++seed) {
    const TestMesh mesh = holed(terrain(20), seed);
    const HoleFilling one = mesh_map::fillHoles(mesh.view(), allHoles(), 1);
    const HoleFilling four = mesh_map::fillHoles(mesh.view(), allHoles(), 4);
    EXPECT_EQ(one.faces, four.faces);
    EXPECT_EQ(one.points, four.points);
    EXPECT_EQ(one.fates, four.fates);
    EXPECT_FALSE(one.faces.empty());

    const std::size_t vertices = mesh.positions.size() / 3;
    const Topology before = mesh_map::buildTopology(mesh.faces, vertices);
    std::vector<std::uint32_t> faces = mesh.faces;
    faces.insert(faces.end(), one.faces.begin(), one.faces.end());
    const Topology after = mesh_map::buildTopology(faces, vertices + one.points.size() / 3);
    EXPECT_EQ(countOf(after.edge_flags, mesh_map::EDGE_NON_MANIFOLD), 0u);
    EXPECT_EQ(countOf(after.edge_flags, mesh_map::EDGE_INCONSISTENT), 0u);
    EXPECT_LT(countOf(after.edge_flags, mesh_map::EDGE_BORDER),
              countOf(before.edge_flags, mesh_map::EDGE_BORDER));
  }
}

TEST(Repair, PartsWhateverIsTangled)
{
  for (unsigned seed = 0; seed < 50; ++seed) {
    const TestMesh mesh = tangle(seed);
    const ManifoldMesh made = mesh_map::makeManifold(mesh.view());
    const Topology after = mesh_map::buildTopology(made.faces, made.vertex_parents.size() / 2);
    EXPECT_EQ(countOf(after.edge_flags, mesh_map::EDGE_NON_MANIFOLD), 0u);
    EXPECT_EQ(countOf(after.vertex_flags, mesh_map::VERTEX_NON_MANIFOLD), 0u);
    EXPECT_EQ(made.face_parents.size() * 3, made.faces.size());
    // and nothing of it is a trap for what closes holes
    mesh_map::fillHoles(mesh.view(), allHoles(), 1);
  }
}

TEST(Repair, SimplifiesWhatIsNotFrozen)
{
  if (!mesh_map::canSimplify()) {
    GTEST_SKIP() << "built without meshoptimizer";
  }
  const TestMesh mesh = terrain(20);
  const std::size_t count = mesh.faceCount();
  std::vector<std::uint32_t> regions(count, 0);
  std::fill(regions.begin() + std::ptrdiff_t(count / 2), regions.end(), 1u);
  std::vector<std::uint8_t> frozen(count, 0);
  const auto found = mesh_map::simplifyFaces(mesh.view(), regions, frozen, count / 4, 1e9);
  EXPECT_LT(found.regions.size(), count / 2);
  EXPECT_EQ(found.faces.size(), 3 * found.regions.size());
  std::fill(frozen.begin(), frozen.end(), std::uint8_t{1});
  EXPECT_EQ(mesh_map::simplifyFaces(mesh.view(), regions, frozen, 1, 1e9).faces, mesh.faces);
}

}  // namespace
