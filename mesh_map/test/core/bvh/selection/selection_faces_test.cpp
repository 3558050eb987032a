#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/tree/back_end.h>

#include <gtest/gtest.h>

#include "regions.h"

using namespace mesh_map;

namespace {

using Faces = std::vector<std::uint32_t>;

const SelectionMode MODES[] = {SelectionMode::TOUCHING, SelectionMode::INSIDE};

Faces allFaces(const TestMesh& mesh)
{
  Faces faces(mesh.faceCount());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    faces[i] = static_cast<std::uint32_t>(i);
  }
  return faces;
}

}  // namespace

TEST(SelectFaces, isALoopOverAllFaces)
{
  std::size_t selected = 0, partly = 0;
  for (const TestMesh& mesh : testMeshes()) {
    const Bvh bvh = Bvh::build(mesh.view());
    for (const NamedRegion& named : regionsFor(mesh, 1)) {
      for (const SelectionMode mode : MODES) {
        const Faces faces = bruteForce(mesh, *named.region, mode);
        ASSERT_EQ(selectFaces(bvh, *named.region, mode), faces) << mesh.name << ", " << named.name;
        selected += faces.empty() ? 0 : 1;
        partly += faces.empty() || faces.size() == mesh.faceCount() ? 0 : 1;
      }
    }
  }
  EXPECT_GT(selected, 500u);
  EXPECT_GT(partly, 300u);
}

TEST(SelectFaces, isExactForNumbersThatAreNoFloats)
{
  std::mt19937 random(5);
  std::normal_distribution<double> any(0.0, 1.0);
  const auto expectExact = [](const TestMesh& mesh, const Bvh& bvh, const Region& region) {
    const Faces faces = bruteForce(mesh, region, SelectionMode::TOUCHING);
    EXPECT_EQ(selectFaces(bvh, region), faces) << mesh.name;
    return !faces.empty() && faces.size() < mesh.faceCount();
  };
  // planes of a mesh with a long and two short sides: normals that are too small for floats
  TestMesh stretched = soup(100);
  const double scale[3] = {1e31, 1e-22, 1e-32};
  for (std::size_t i = 0; i < stretched.positions.size(); ++i) {
    stretched.positions[i] *= static_cast<float>(scale[i % 3]);
  }
  // balls so small that their squares are
  TestMesh tiny = soup(100);
  for (float& position : tiny.positions) {
    position *= 1e-22f;
  }
  const Bvh bvh = Bvh::build(stretched.view()), tiny_bvh = Bvh::build(tiny.view());
  int planes = 0, balls = 0;
  for (std::size_t i = 0; i < 300; ++i) {
    Plane plane{};
    Vector center;
    double squared = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      plane[axis] = any(random) / scale[axis];
      plane[3] -= plane[axis] * stretched.positions[3 * i + axis];
      center[axis] = 1e-22 * any(random);
      squared += std::pow(center[axis] - tiny.positions[3 * i + axis], 2);
    }
    planes += expectExact(stretched, bvh, ConvexRegion({plane})) ? 1 : 0;
    balls += expectExact(tiny, tiny_bvh, SphereRegion(center, std::sqrt(squared))) ? 1 : 0;
  }
  EXPECT_GT(planes, 100);
  EXPECT_GT(balls, 100);
}

TEST(SelectFaces, passesWhatTheMaskHasNot)
{
  std::mt19937 random(2);
  for (const TestMesh& mesh : {terrain(40), soup(1000), identical(1000)}) {
    const Bvh bvh = Bvh::build(mesh.view());
    for (const double share : {0.0, 0.01, 0.5, 1.0}) {
      std::vector<std::uint8_t> mask(mesh.faceCount());
      for (std::uint8_t& entry : mask) {
        entry = std::bernoulli_distribution(share)(random) ? 7 : 0;
      }
      for (const NamedRegion& named : regionsFor(mesh, 3, 2)) {
        for (const SelectionMode mode : MODES) {
          ASSERT_EQ(selectFaces(bvh, *named.region, mode, mask),
                    bruteForce(mesh, *named.region, mode, mask))
              << mesh.name << ", " << named.name;
        }
      }
    }
  }
}

TEST(SelectFaces, ofTheBoundsAreAll)
{
  for (const TestMesh& mesh : testMeshes()) {
    const Box bounds = boundsOf(mesh.positions.data(), mesh.positions.size() / 3);
    std::vector<Plane> planes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      planes.push_back({0, 0, 0, -bounds.lower[axis]});
      planes.back()[axis] = 1.0;
      planes.push_back({0, 0, 0, bounds.upper[axis]});
      planes.back()[axis] = -1.0;
    }
    const Bvh bvh = Bvh::build(mesh.view());
    EXPECT_EQ(selectFaces(bvh, ConvexRegion(planes), SelectionMode::INSIDE), allFaces(mesh))
        << mesh.name;
    for (Plane& plane : planes) {  // the other side of each: only what lies on it
      ConvexRegion beyond({{-plane[0], -plane[1], -plane[2], -plane[3]}});
      for (const std::uint32_t face : selectFaces(bvh, beyond)) {
        EXPECT_NE(beyond.triangle(mesh.corners(face).data()), Side::OUTSIDE);
      }
      EXPECT_FALSE(selectFaces(bvh, beyond).empty()) << mesh.name;
    }
  }
}

TEST(SelectFaces, areInOneOfTwoHalves)
{
  std::mt19937 random(4);
  std::normal_distribution<double> any;
  for (const TestMesh& mesh : testMeshes()) {
    const Bvh bvh = Bvh::build(mesh.view());
    for (int i = 0; i < 20; ++i) {
      const std::vector<float> corners =
          mesh.corners(random() % static_cast<unsigned>(mesh.faceCount()));
      Plane plane{any(random), any(random), any(random), 0.0};
      plane[3] = -plane[0] * corners[0] - plane[1] * corners[1] - plane[2] * corners[2] + 1e-3;
      const ConvexRegion here({plane}), there({{-plane[0], -plane[1], -plane[2], -plane[3]}});
      const Faces inside = selectFaces(bvh, here, SelectionMode::INSIDE);
      const Faces touched = selectFaces(bvh, there);
      Faces both;
      std::set_union(inside.begin(), inside.end(), touched.begin(), touched.end(),
                     std::back_inserter(both));
      ASSERT_EQ(both, allFaces(mesh)) << mesh.name;
    }
  }
}

TEST(SelectFaces, growWithTheRadius)
{
  for (const TestMesh& mesh : testMeshes()) {
    const Bvh bvh = Bvh::build(mesh.view());
    const std::vector<float> corners = mesh.corners(mesh.faceCount() / 2);
    for (const SelectionMode mode : MODES) {
      Faces before;
      for (double radius = 1e-9; radius < 1e8; radius *= 3.0) {
        const SphereRegion sphere({corners[0] + 1e-3, corners[1], corners[2]}, radius);
        const Faces faces = selectFaces(bvh, sphere, mode);
        ASSERT_TRUE(std::includes(faces.begin(), faces.end(), before.begin(), before.end()))
            << mesh.name << ", " << radius;
        before = faces;
      }
      EXPECT_EQ(before, allFaces(mesh)) << mesh.name;
    }
  }
}

TEST(SelectFaces, findsTheBigTriangleAroundAFrustum)
{
  const TestMesh mesh = withGiant(soup(300));
  const Bvh bvh = Bvh::build(mesh.view());
  const Matrix camera = product(perspective(0.1, 0.1, 100.0), viewOf({40, 40, 5}, {40, 40, -2}));
  const Faces giant{300};
  EXPECT_EQ(selectFaces(bvh, ConvexRegion(frustumPlanes(camera))), giant);
  EXPECT_EQ(selectFaces(bvh, LassoRegion({{-0.1, -0.1}, {0.1, -0.1}, {0, 0.1}}, camera)), giant);
  EXPECT_EQ(selectFaces(bvh, SphereRegion({40, 40, 0}, 2.0)), giant);
  EXPECT_EQ(selectFaces(bvh, SphereRegion({40, 40, 0}, 1.999)), Faces());
}

TEST(SelectFaces, endWhereCanceled)
{
  const TestMesh mesh = terrain(40);
  const Bvh bvh = Bvh::build(mesh.view());
  const SphereRegion sphere({5.0, 5.0, 0.0}, 2.0);
  std::atomic<bool> cancel{true};
  BvhOptions run;
  run.cancel = &cancel;
  EXPECT_THROW(selectFaces(bvh, sphere, SelectionMode::TOUCHING, {}, run), Canceled);
  cancel = false;
  EXPECT_EQ(selectFaces(bvh, sphere, SelectionMode::TOUCHING, {}, run), selectFaces(bvh, sphere));
}

TEST(SelectFaces, areCounted)
{
  const TestMesh mesh = terrain(5);
  const Bvh bvh = Bvh::build(mesh.view());
  const std::uint64_t spheres = queryCount(BackEnd::NATIVE, Query::SPHERE);
  const std::uint64_t frusta = queryCount(BackEnd::NATIVE, Query::FRUSTUM);
  const std::uint64_t lassos = queryCount(BackEnd::NATIVE, Query::LASSO);
  selectFaces(bvh, SphereRegion({0, 0, 0}, 1.0));
  selectFaces(bvh, ConvexRegion({{1, 0, 0, 0}}));
  selectFaces(bvh, ConvexRegion({{1, 0, 0, 0}}));
  selectFaces(bvh, LassoRegion({{0, 0}, {1, 0}, {0, 1}}, orthographic(1, -9, 9)));
  EXPECT_EQ(queryCount(BackEnd::NATIVE, Query::SPHERE), spheres + 1);
  EXPECT_EQ(queryCount(BackEnd::NATIVE, Query::FRUSTUM), frusta + 2);
  EXPECT_EQ(queryCount(BackEnd::NATIVE, Query::LASSO), lassos + 1);
}
