// Many closest points at once are what one at a time are; batches can be canceled.
#include <mesh_map/bvh/tree/back_end.h>

#include <atomic>
#include <thread>

#include "closest_checks.h"

using mesh_map::BackEnd;
using mesh_map::Bvh;
using mesh_map::BvhOptions;
using mesh_map::ClosestOptions;
using mesh_map::Query;

namespace {

std::vector<double> flat(const std::vector<Point>& points)
{
  std::vector<double> result;
  for (const Point& point : points) {
    result.insert(result.end(), point.begin(), point.end());
  }
  return result;
}

std::uint64_t nativeCount()
{
  return queryCount(BackEnd::NATIVE, Query::CLOSEST_POINT);
}

void expectEach(const Bvh& bvh, const std::vector<double>& points, const ClosestOptions& options,
                const BvhOptions& run)
{
  const mesh_map::SurfaceHits hits = closestPoints(bvh, points, options, run);
  const std::size_t count = points.size() / 3;
  ASSERT_EQ(hits.faces.size(), count);
  ASSERT_EQ(hits.distances.size(), count);
  ASSERT_EQ(hits.positions.size(), 3 * count);
  ASSERT_EQ(hits.barycentric.size(), 3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    ClosestOptions own = options;
    if (options.normals.size() > 3) {
      own.normals = {options.normals.data() + 3 * i, 3};
    }
    const double* const at = &hits.positions[3 * i];
    const double* const weights = &hits.barycentric[3 * i];
    expectSame({hits.faces[i],
                {weights[0], weights[1], weights[2]},
                {at[0], at[1], at[2]},
                hits.distances[i]},
               closestPoint(bvh, &points[3 * i], own), std::to_string(i));
  }
}

TEST(ClosestPoints, AreEachWhatOneAloneIs)
{
  for (const TestMesh& mesh : testMeshes()) {
    SCOPED_TRACE(mesh.name);
    const Bvh bvh = Bvh::build(mesh.view());
    std::vector<double> points = flat(pointsAround(mesh, 50));
    points.insert(points.end(), {NAN, 0, 0, 0.1, 0.2, 0.3});
    std::vector<double> normals(points.size());
    std::mt19937 random(8);
    for (double& x : normals) {
      x = static_cast<double>(random() % 5) - 2.0;  // some are 0
    }
    std::vector<std::uint8_t> mask(mesh.faceCount());
    for (std::uint8_t& entry : mask) {
      entry = random() % 2;
    }
    for (const unsigned threads : {1u, 2u, 5u}) {
      BvhOptions run;
      run.threads = threads;
      expectEach(bvh, points, {}, run);
    }
    ClosestOptions options;
    options.normals = normals;
    options.max_angle = 1.0;
    options.max_distance = 100.0;
    expectEach(bvh, points, options, {});
    options.normals = {normals.data(), 3};
    options.mask = mask;
    expectEach(bvh, points, options, {});
  }
}

TEST(ClosestPoints, OfNoPointsAreNone)
{
  const mesh_map::SurfaceHits hits = closestPoints(Bvh::build(terrain(1).view()), {});
  EXPECT_TRUE(hits.faces.empty() && hits.positions.empty());
}

TEST(ClosestPoints, AreCounted)
{
  const Bvh bvh = Bvh::build(terrain(5).view());
  const std::vector<double> points(3 * 1234);
  const std::uint64_t before = nativeCount();
  closestPoints(bvh, points);
  EXPECT_EQ(nativeCount(), before + 1234);
  closestPoint(bvh, points.data());
  EXPECT_EQ(nativeCount(), before + 1235);
}

TEST(ClosestPoints, TellHowFarTheyAre)
{
  const Bvh bvh = Bvh::build(terrain(5).view());
  std::vector<double> told;
  BvhOptions run;
  run.progress = [&](double fraction) { told.push_back(fraction); };
  closestPoints(bvh, std::vector<double>(3 * 20'000), {}, run);
  ASSERT_GT(told.size(), 10u);
  EXPECT_GE(told.front(), 0.0);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1.0);
}

TEST(ClosestPoints, EndWhenCancelled)
{
  const Bvh bvh = Bvh::build(identical(100'000).view());
  const std::vector<double> points(3 * 100'000, 0.25);  // minutes: each looks at each face
  for (const unsigned threads : {1u, 3u}) {
    std::atomic<bool> cancel{true};
    BvhOptions run;
    run.threads = threads;
    run.cancel = &cancel;
    const std::uint64_t before = nativeCount();
    EXPECT_THROW(closestPoints(bvh, points, {}, run), mesh_map::Canceled);
    for (const int milliseconds : {1, 30}) {
      cancel = false;
      std::thread other([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
        cancel = true;
      });
      EXPECT_THROW(closestPoints(bvh, points, {}, run), mesh_map::Canceled);
      other.join();
    }
    EXPECT_EQ(nativeCount(), before);
  }
}

}  // namespace
