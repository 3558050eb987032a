// What surrounds the kernels, without any: whatever a device answers is sound.
#include <mesh_map/bvh/device/bvh_device.h>
#include <mesh_map/bvh/tree/back_end.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "test_queries.h"

using namespace mesh_map;

namespace {

bool operator==(const RayHits& a, const RayHits& b)
{
  return a.faces == b.faces && a.distances == b.distances && a.barycentric == b.barycentric;
}

bool operator==(const SurfaceHits& a, const SurfaceHits& b)
{
  return a.faces == b.faces && a.distances == b.distances && a.positions == b.positions &&
         a.barycentric == b.barycentric;
}

/// Answers that say no more than that the device does not know, each in another way: a face count
/// or more is no triangle.
std::vector<std::vector<std::uint32_t>> uselessAnswers(const Bvh& bvh, std::size_t count)
{
  std::vector<std::vector<std::uint32_t>> all;
  for (std::uint32_t answer :
       {DEVICE_DOUBT, static_cast<std::uint32_t>(bvh.faceCount()), BVH_LEAF, DEVICE_DOUBT - 1}) {
    all.emplace_back(count, answer);
  }
  return all;
}

struct Fixture : ::testing::Test
{
  const TestMesh mesh = terrain(20);
  const Bvh bvh = Bvh::build(mesh.view());
  const TestQueries queries{mesh, 50};
  const RayBatch rays{queries.origins, queries.directions, queries.max_distances};
  const std::size_t point_count = queries.points.size() / 3;
};

/// Position of each face in the order of the leaves.
std::vector<std::uint32_t> positions(const Bvh& bvh)
{
  std::vector<std::uint32_t> result(bvh.faceCount());
  for (std::size_t i = 0; i < bvh.faceCount(); ++i) {
    result[bvh.faces()[i]] = static_cast<std::uint32_t>(i);
  }
  return result;
}

}  // namespace

using Device = Fixture;

TEST_F(Device, WhatIsInDoubtIsAskedNatively)
{
  RayOptions options;
  options.mask = queries.mask;
  const RayHits hits = castRays(bvh, rays, options);
  for (const auto& answers : uselessAnswers(bvh, rays.size() * DEVICE_RAY_ANSWERS)) {
    const std::uint64_t before = queryCount(BackEnd::NATIVE, Query::RAY);
    EXPECT_TRUE(finishRays(bvh, rays, options, answers) == hits);
    EXPECT_EQ(queryCount(BackEnd::NATIVE, Query::RAY), before + rays.size());
    EXPECT_EQ(finishRaysAny(bvh, rays, options, answers), raysHitAny(bvh, rays, options));
  }
  ClosestOptions closest;
  closest.max_distance = 2.0;
  closest.mask = queries.mask;
  const SurfaceHits nearest = closestPoints(bvh, queries.points, closest);
  for (const auto& answers : uselessAnswers(bvh, point_count * DEVICE_CANDIDATES)) {
    const std::uint64_t before = queryCount(BackEnd::NATIVE, Query::CLOSEST_POINT);
    EXPECT_TRUE(finishPoints(bvh, queries.points, closest, answers) == nearest);
    EXPECT_EQ(queryCount(BackEnd::NATIVE, Query::CLOSEST_POINT), before + point_count);
  }
  const SphereRegion sphere({5.0, 5.0, 0.0}, 3.0);
  for (const SelectionMode mode : {SelectionMode::TOUCHING, SelectionMode::INSIDE}) {
    for (const std::uint8_t verdict : {DEVICE_UNSURE, std::uint8_t{4}, std::uint8_t{255}}) {
      const std::vector<std::uint8_t> verdicts(bvh.faceCount(), verdict);
      EXPECT_EQ(finishSelection(bvh, sphere, mode, queries.mask, verdicts),
                selectFaces(bvh, sphere, mode, queries.mask));
    }
  }
}

TEST_F(Device, CandidatesAreDecidedInDoublePrecision)
{
  const RayHits hits = castRays(bvh, rays);
  const std::vector<std::uint32_t> place = positions(bvh);
  std::vector<std::uint32_t> answers(rays.size() * DEVICE_RAY_ANSWERS, DEVICE_NONE);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    std::uint32_t* const own = answers.data() + DEVICE_RAY_ANSWERS * i;
    // Others that are not nearer, in any order; and what follows an end does not count.
    own[i % 2] = hits.faces[i] == NO_INDEX ? 0 : place[hits.faces[i]];
    own[1 - i % 2] = 1;
    own[2] = i % 3 == 0 ? DEVICE_NONE : own[0];
    own[3] = i % 3 == 0 ? DEVICE_DOUBT : own[1];
  }
  const std::uint64_t before = queryCount(BackEnd::NATIVE, Query::RAY);
  EXPECT_TRUE(finishRays(bvh, rays, {}, answers) == hits);
  EXPECT_EQ(queryCount(BackEnd::NATIVE, Query::RAY), before);
  EXPECT_EQ(finishRaysAny(bvh, rays, {}, answers), raysHitAny(bvh, rays));

  const SurfaceHits nearest = closestPoints(bvh, queries.points);
  answers.assign(point_count * DEVICE_CANDIDATES, DEVICE_NONE);
  for (std::size_t i = 0; i < point_count; ++i) {
    if (nearest.faces[i] != NO_INDEX) {
      answers[DEVICE_CANDIDATES * i] = 1;
      answers[DEVICE_CANDIDATES * i + 1] = place[nearest.faces[i]];
    }
  }
  EXPECT_TRUE(finishPoints(bvh, queries.points, {}, answers) == nearest);

  // Nothing at all is an answer, too.
  const std::vector<std::uint32_t> none(rays.size() * DEVICE_RAY_ANSWERS, DEVICE_NONE);
  EXPECT_TRUE(finishRays(bvh, rays, {}, none).faces ==
              std::vector<std::uint32_t>(rays.size(), NO_INDEX));
  EXPECT_EQ(finishRaysAny(bvh, rays, {}, none), std::vector<std::uint8_t>(rays.size(), 0));
}

TEST_F(Device, VerdictsAreTaken)
{
  const ConvexRegion all({{0.0, 0.0, 1.0, 1e6}});
  const std::vector<std::uint32_t> place = positions(bvh);
  std::vector<std::uint8_t> verdicts(bvh.faceCount(), DEVICE_OUTSIDE);
  verdicts[place[3]] = DEVICE_TOUCHING;
  verdicts[place[700]] = DEVICE_INSIDE;
  verdicts[place[5]] = DEVICE_INSIDE;
  verdicts[place[4]] = DEVICE_UNSURE;  // inside, as the region says
  using Faces = std::vector<std::uint32_t>;
  EXPECT_EQ(finishSelection(bvh, all, SelectionMode::TOUCHING, {}, verdicts),
            (Faces{3, 4, 5, 700}));
  EXPECT_EQ(finishSelection(bvh, all, SelectionMode::INSIDE, {}, verdicts), (Faces{4, 5, 700}));
  std::vector<std::uint8_t> mask(bvh.faceCount(), 1);
  mask[5] = 0;
  EXPECT_EQ(finishSelection(bvh, all, SelectionMode::INSIDE, mask, verdicts), (Faces{4, 700}));
}

TEST_F(Device, RootsHaveAllThatIsSelectedOnce)
{
  for (const double radius : {0.0, 0.01, 1.0, 5.0, 100.0}) {
    const SphereRegion sphere({5.0, 5.0, 0.0}, radius);
    std::vector<unsigned> times(bvh.faceCount(), 0);
    const std::vector<std::uint32_t> roots = selectionRoots(bvh, sphere);
    ASSERT_EQ(roots.size() % 2, 0u);
    for (std::size_t i = 0; i < roots.size(); i += 2) {
      std::size_t first = roots[i + 1], count = 0;
      if (isLeaf(roots[i])) {
        first = roots[i] & ~BVH_LEAF;
        count = roots[i + 1];
      } else {
        for (const std::uint32_t part : bvh.nodes()[roots[i]].count) {
          count += part;
        }
      }
      for (std::size_t k = first; k < first + count; ++k) {
        ++times[bvh.faces()[k]];
      }
    }
    EXPECT_LE(*std::max_element(times.begin(), times.end()), 1u);
    for (const std::uint32_t face : selectFaces(bvh, sphere)) {
      EXPECT_EQ(times[face], 1u);
    }
  }
  EXPECT_TRUE(selectionRoots(bvh, SphereRegion({5.0, 5.0, 500.0}, 3.0)).empty());
  EXPECT_TRUE(selectionRoots(bvh, SphereRegion({5.0, 5.0, 0.0}, -1.0)).empty());
  EXPECT_TRUE(selectionRoots(bvh, ConvexRegion({{0.0, 0.0, 0.0, 1.0}})).empty());
  std::array<double, 16> identity{};
  identity[0] = identity[5] = identity[10] = identity[15] = 1.0;
  const LassoRegion lasso({{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}, identity);
  EXPECT_THROW(selectionRoots(bvh, lasso), std::invalid_argument);
}

TEST_F(Device, NormalsAreANativeQuestion)
{
  const std::vector<double> up = {0.0, 0.0, 1.0};
  ClosestOptions options;
  options.normals = up;
  const std::vector<std::uint32_t> none(point_count * DEVICE_CANDIDATES, DEVICE_NONE);
  EXPECT_THROW(finishPoints(bvh, queries.points, options, none), std::invalid_argument);
}

TEST_F(Device, MasksAreInTheOrderOfTheLeaves)
{
  std::vector<std::uint8_t> mask(bvh.faceCount(), 0);
  mask[17] = 1;
  const std::vector<std::uint8_t> by_triangle = deviceMask(bvh, mask);
  ASSERT_EQ(by_triangle.size(), bvh.faceCount());
  for (std::size_t i = 0; i < by_triangle.size(); ++i) {
    EXPECT_EQ(by_triangle[i], bvh.faces()[i] == 17 ? 1 : 0);
  }
}

TEST_F(Device, ArraysThatDoNotFitAreRefused)
{
  const std::vector<std::uint32_t> answers(DEVICE_RAY_ANSWERS * rays.size() - 1, DEVICE_NONE);
  const std::vector<std::uint8_t> mask(3, 1), verdicts(bvh.faceCount() + 1, 0);
  const std::vector<double> two(2, 0.0);
  RayOptions masked;
  masked.mask = mask;
  const std::vector<std::uint32_t> fitting(DEVICE_RAY_ANSWERS * rays.size(), DEVICE_NONE);
  EXPECT_THROW(finishRays(bvh, rays, {}, answers), std::invalid_argument);
  EXPECT_THROW(finishRays(bvh, rays, masked, fitting), std::invalid_argument);
  EXPECT_THROW(finishRaysAny(bvh, rays, {}, answers), std::invalid_argument);
  EXPECT_THROW(packRays(bvh, {two, queries.directions, {}}), std::invalid_argument);
  EXPECT_THROW(packPoints(bvh, two, {}), std::invalid_argument);
  EXPECT_THROW(finishPoints(bvh, queries.points, {}, answers), std::invalid_argument);
  EXPECT_THROW(deviceMask(bvh, mask), std::invalid_argument);
  const SphereRegion sphere({5.0, 5.0, 0.0}, 3.0);
  EXPECT_THROW(finishSelection(bvh, sphere, SelectionMode::INSIDE, {}, verdicts),
               std::invalid_argument);
}

TEST_F(Device, EmptyBatchesAreDone)
{
  EXPECT_EQ(packRays(bvh, {}).size(), DEVICE_RAY_FLOATS);
  EXPECT_TRUE(finishRays(bvh, {}, {}, {}).faces.empty());
  EXPECT_EQ(packPoints(bvh, {}, {}).size(), DEVICE_POINT_FLOATS);
  EXPECT_TRUE(finishPoints(bvh, {}, {}, {}).faces.empty());
}

TEST_F(Device, AllIsCancelled)
{
  const std::atomic<bool> cancel{true};
  BvhOptions run;
  run.cancel = &cancel;
  const std::vector<std::uint32_t> answers(DEVICE_RAY_ANSWERS * rays.size(), DEVICE_DOUBT);
  const std::vector<std::uint32_t> more(DEVICE_CANDIDATES * point_count, DEVICE_DOUBT);
  const std::vector<std::uint8_t> verdicts(bvh.faceCount(), DEVICE_UNSURE);
  EXPECT_THROW(packRays(bvh, rays, run), Canceled);
  EXPECT_THROW(finishRays(bvh, rays, {}, answers, run), Canceled);
  EXPECT_THROW(finishRaysAny(bvh, rays, {}, answers, run), Canceled);
  EXPECT_THROW(packPoints(bvh, queries.points, {}, run), Canceled);
  EXPECT_THROW(finishPoints(bvh, queries.points, {}, more, run), Canceled);
  EXPECT_THROW(finishSelection(bvh, SphereRegion({5.0, 5.0, 0.0}, 3.0), SelectionMode::INSIDE, {},
                               verdicts, run),
               Canceled);
}

TEST_F(Device, PackedNumbersAreNumbers)
{
  for (const TestMesh& other : testMeshes()) {
    SCOPED_TRACE(other.name);
    const Bvh tree = Bvh::build(other.view());
    const TestQueries hard(other, 20);
    const auto packed_rays =
        packRays(tree, {hard.origins, hard.directions, hard.max_distances}, {});
    const auto packed_points = packPoints(tree, hard.points, {});
    ASSERT_EQ(packed_rays.size(), DEVICE_RAY_FLOATS * (1 + hard.max_distances.size()));
    ASSERT_EQ(packed_points.size(), DEVICE_POINT_FLOATS * (1 + hard.points.size() / 3));
    for (std::size_t i = 0; i < packed_rays.size(); ++i) {
      EXPECT_TRUE(i % DEVICE_RAY_FLOATS == 7 || std::isfinite(packed_rays[i])) << i;
    }
    for (std::size_t i = 0; i < packed_points.size(); ++i) {
      EXPECT_TRUE(std::isfinite(packed_points[i])) << i;
    }
  }
}

TEST(DeviceKernels, AreInTheLibrary)
{
  const std::string text = BVH_KERNELS;
  for (const char* kernel : {"cast_rays", "closest_points", "select_sphere", "select_planes"}) {
    EXPECT_NE(text.find("kernel void " + std::string(kernel) + "("), std::string::npos) << kernel;
  }
  EXPECT_EQ(text.find("double "), text.find("double precision"));  // no variable of that type
  const auto defines = [&text](const std::string& name, std::uint64_t value) {
    const std::size_t at = text.find("#define " + name + " ");
    return at != std::string::npos &&
           std::stoull(text.substr(at + name.size() + 9), nullptr, 0) == value;
  };
  EXPECT_TRUE(defines("LEAF", BVH_LEAF));
  EXPECT_TRUE(defines("NONE", DEVICE_NONE));
  EXPECT_TRUE(defines("DOUBT", DEVICE_DOUBT));
  EXPECT_TRUE(defines("BACK_FACES", DEVICE_BACK_FACES));
  EXPECT_TRUE(defines("MASKED", DEVICE_MASKED));
  EXPECT_TRUE(defines("ANY_HIT", DEVICE_ANY_HIT));
  EXPECT_TRUE(defines("RAY_ANSWERS", DEVICE_RAY_ANSWERS));
  EXPECT_TRUE(defines("POINT_ANSWERS", DEVICE_CANDIDATES));
  EXPECT_TRUE(defines("OUTSIDE", DEVICE_OUTSIDE));
  EXPECT_TRUE(defines("TOUCHING", DEVICE_TOUCHING));
  EXPECT_TRUE(defines("INSIDE", DEVICE_INSIDE));
  EXPECT_TRUE(defines("UNSURE", DEVICE_UNSURE));
  EXPECT_TRUE(defines("STACK_SIZE", BVH_STACK));
}
