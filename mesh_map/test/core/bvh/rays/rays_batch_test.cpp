#include <mesh_map/bvh/tree/back_end.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <atomic>
#include <stdexcept>
#include <thread>

#include "ray_checks.h"
#include "ray_samples.h"

using mesh_map::Bvh;
using mesh_map::BvhOptions;
using mesh_map::Canceled;
using mesh_map::castRays;
using mesh_map::Ray;
using mesh_map::RayBatch;
using mesh_map::RayHit;
using mesh_map::RayHits;
using mesh_map::RayOptions;
using mesh_map::raysHitAny;

namespace {

/// Pictures, rays anywhere, and such that hit nothing by nature, mixed: packets of rays are formed
/// and broken up everywhere.
Rays mixedRays(const TestMesh& mesh)
{
  RaySamples samples(mesh);
  Rays rays;
  for (std::size_t i = 0; i < 40; ++i) {
    for (const Rays& more : {samples.picture(37, 3), samples.anywhere(5), samples.garbage(2),
                             samples.fromAfar(1e6, 1), samples.fromAfar(1e300, 1)}) {
      rays.insert(rays.end(), more.begin(), more.end());
    }
  }
  return rays;
}

TEST(RayBatch, answers_as_single_rays_do_on_any_number_of_threads)
{
  for (const TestMesh& mesh : {terrain(60), soup(2000), cube(8), withGiant(soup(300))}) {
    const Bvh bvh = Bvh::build(mesh.view());
    const Rays rays = mixedRays(mesh);
    const RayArrays arrays(rays);
    for (const unsigned threads : {1u, 2u, 7u}) {
      BvhOptions run;
      run.threads = threads;
      const RayHits hits = castRays(bvh, arrays.batch(), {}, run);
      const std::vector<std::uint8_t> any = raysHitAny(bvh, arrays.batch(), {}, run);
      ASSERT_EQ(hits.faces.size(), rays.size());
      ASSERT_EQ(hits.distances.size(), rays.size());
      ASSERT_EQ(hits.barycentric.size(), 3 * rays.size());
      ASSERT_EQ(any.size(), rays.size());
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const RayHit hit = castRay(bvh, rays[i]);
        ASSERT_EQ(hits.faces[i], hit.face) << describe(rays[i]);
        ASSERT_EQ(hits.distances[i], hit.distance) << describe(rays[i]);
        for (std::size_t k = 0; k < 3; ++k) {
          ASSERT_EQ(hits.barycentric[3 * i + k], hit.barycentric[k]) << describe(rays[i]);
        }
        ASSERT_EQ(any[i], hit.face != mesh_map::NO_INDEX ? 1 : 0) << describe(rays[i]);
        ASSERT_EQ(rayHitsAny(bvh, rays[i]), any[i] == 1) << describe(rays[i]);
      }
    }
  }
}

TEST(RayBatch, takes_one_origin_and_one_maximum_distance_for_all)
{
  const TestMesh mesh = terrain(20);
  const Bvh bvh = Bvh::build(mesh.view());
  Rays rays = RaySamples(mesh).picture(40, 30);
  for (Ray& ray : rays) {
    ray.max_distance = 30.0;
  }
  const RayArrays arrays(rays);
  const std::vector<double> origin(arrays.origins.begin(), arrays.origins.begin() + 3);
  const std::vector<double> limit = {30.0};
  const RayHits one = castRays(bvh, {origin, arrays.directions, limit});
  const RayHits each = castRays(bvh, arrays.batch());
  EXPECT_EQ(one.faces, each.faces);
  EXPECT_EQ(one.distances, each.distances);
  EXPECT_EQ(one.barycentric, each.barycentric);
  EXPECT_GT(std::count_if(one.faces.begin(), one.faces.end(),
                          [](auto face) { return face != mesh_map::NO_INDEX; }),
            0);
}

TEST(RayBatch, may_be_empty)
{
  const Bvh bvh = Bvh::build(cube(1).view());
  const std::vector<double> origin = {0, 0, 0};
  EXPECT_TRUE(castRays(bvh, {origin, {}, {}}).faces.empty());
  EXPECT_TRUE(raysHitAny(bvh, {origin, {}, {}}).empty());
}

TEST(RayBatch, refuses_arrays_that_do_not_fit)
{
  const Bvh bvh = Bvh::build(cube(1).view());
  const std::vector<double> two = {1, 2}, three = {1, 2, 3}, six(6, 1.0), nine(9, 1.0);
  const std::vector<std::uint8_t> mask(5, 1);
  RayOptions masked;
  masked.mask = mask;
  const std::pair<std::function<void()>, std::string> cases[] = {
      {[&] {
         castRays(bvh, {three, two, {}});
       },
       "2 numbers are no directions"},
      {[&] {
         castRays(bvh, {two, six, {}});
       },
       "2 numbers of origins do not fit 2 rays"},
      {[&] {
         raysHitAny(bvh, {{}, six, {}});
       },
       "0 numbers of origins do not fit 2 rays"},
      {[&] {
         raysHitAny(bvh, {nine, six, {}});
       },
       "9 numbers of origins do not fit 2 rays"},
      {[&] {
         castRays(bvh, {six, six, three});
       },
       "3 maximum distances do not fit 2 rays"},
      {[&] {
         castRays(bvh, {six, six, {}}, masked);
       },
       "a mask of 5 entries does not fit"},
      {[&] {
         raysHitAny(bvh, {six, six, {}}, masked);
       },
       "a mask of 5 entries does not fit"},
      {[&] { castRay(bvh, Ray(), masked); }, "a mask of 5 entries does not fit"},
      {[&] { rayHitsAny(bvh, Ray(), masked); }, "a mask of 5 entries does not fit"},
  };
  for (const auto& [call, message] : cases) {
    try {
      call();
      ADD_FAILURE() << message;
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(std::string(error.what()).find(message), 0u) << error.what();
    }
  }
}

TEST(RayBatch, ends_when_cancelled_and_tells_how_far_it_is)
{
  const TestMesh mesh = terrain(20);
  const Bvh bvh = Bvh::build(mesh.view());
  const RayArrays arrays(RaySamples(mesh).anywhere(30000));
  for (const unsigned threads : {1u, 2u}) {
    std::vector<double> told;
    BvhOptions run;
    run.threads = threads;
    run.progress = [&told](double fraction) { told.push_back(fraction); };
    castRays(bvh, arrays.batch(), {}, run);
    ASSERT_GT(told.size(), 5u);
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_EQ(told.back(), 1.0);

    std::atomic<bool> cancel{false};
    run.cancel = &cancel;
    run.progress = [&](double fraction) { cancel = fraction > 0.3; };
    EXPECT_THROW(castRays(bvh, arrays.batch(), {}, run), Canceled);
    cancel = false;
    EXPECT_THROW(raysHitAny(bvh, arrays.batch(), {}, run), Canceled);
    cancel = true;
    EXPECT_THROW(raysHitAny(bvh, arrays.batch(), {}, run), Canceled);
  }
}

TEST(RayBatch, counts_each_ray_once)
{
  const auto count = [] {
    return mesh_map::queryCount(mesh_map::BackEnd::NATIVE, mesh_map::Query::RAY);
  };
  const TestMesh mesh = cube(2);
  const Bvh bvh = Bvh::build(mesh.view());
  const RayArrays arrays(RaySamples(mesh).anywhere(77));
  std::uint64_t before = count();
  castRays(bvh, arrays.batch());
  EXPECT_EQ(count() - before, 77u);
  before = count();
  raysHitAny(bvh, arrays.batch());
  EXPECT_EQ(count() - before, 77u);
  before = count();
  castRay(bvh, Ray());
  rayHitsAny(bvh, Ray());
  EXPECT_EQ(count() - before, 2u);
}

}  // namespace
