#include "spatial/spatial_queries.h"

#include <atomic>
#include <chrono>
#include <thread>

#include "query_fixture.h"

using mesh_map::BackEnd;
using mesh_map::ConvexRegion;
using mesh_map::Query;
using mesh_map::queryCount;
using mesh_map::SphereRegion;
using query_test::BvhPtr;
using query_test::Questions;
using query_test::soup;
using query_test::waves;
using rviz_mesh_plugin::SpatialQueries;

namespace {

struct Case
{
  std::string name;
  BvhPtr bvh;
  double offset;
};

std::vector<Case> cases()
{
  return {{"waves", waves(30), 0.0},
          {"far waves", waves(20, 1e6f), 1e6},
          {"waves and a giant", waves(20, 0.0f, true), 0.0},
          {"soup", soup(400), 0.0},
          {"identical", soup(1, 500), 0.0},
          {"one", soup(1), 0.0}};
}

class SpatialQueriesTest : public query_test::DeviceTest
{
};

/// What was counted since.
class Count
{
 public:
  explicit Count(Query query) : query_(query) {}
  std::uint64_t operator()(BackEnd back_end) const
  {
    return queryCount(back_end, query_) - before_[static_cast<std::size_t>(back_end)];
  }

 private:
  const Query query_;
  const std::uint64_t before_[2] = {queryCount(BackEnd::NATIVE, query_),
                                    queryCount(BackEnd::OPENCL, query_)};
};

}  // namespace

TEST_F(SpatialQueriesTest, casts_rays_like_the_native_queries)
{
  for (const Case& c : cases()) {
    const SpatialQueries queries(c.bvh, options());
    ASSERT_TRUE(queries.waitForDevice());
    const Questions questions(2000, c.offset);
    std::vector<double> limits(questions.rays().size(), 3.0);
    limits[5] = std::nan("");
    const double limit = 4.0;
    for (const auto& ray_limits :
         {mesh_map::ArrayView<double>(), {&limit, 1}, mesh_map::ArrayView<double>(limits)}) {
      auto rays = questions.rays();
      rays.max_distances = ray_limits;
      const auto expected = mesh_map::castRays(*c.bvh, rays);
      const Count count(Query::RAY);
      EXPECT_TRUE(queries.castRays(rays) == expected) << c.name;
      EXPECT_EQ(count(BackEnd::OPENCL), rays.size());
      rays.origins = {questions.points.data() + 3, 3};
      EXPECT_TRUE(queries.castRays(rays) == mesh_map::castRays(*c.bvh, rays))
          << c.name << ", all from one origin";
    }
  }
}

TEST_F(SpatialQueriesTest, selects_like_the_native_queries)
{
  for (const Case& c : cases()) {
    const SpatialQueries queries(c.bvh, options());
    ASSERT_TRUE(queries.waitForDevice());
    const double o = c.offset;
    const std::array<double, 3> center{5.0 + o, 4.0 + o, o};
    std::vector<std::unique_ptr<mesh_map::Region>> regions;
    for (const double radius : {0.0, 0.1, 2.5, 100.0, -1.0, std::nan("")}) {
      regions.push_back(std::make_unique<SphereRegion>(center, radius));
    }
    for (const double size : {0.01, 3.0, 50.0}) {
      regions.push_back(std::make_unique<ConvexRegion>(ConvexRegion::box(
          center, {{{0.8, 0.6, 0.0}, {-0.6, 0.8, 0.0}, {0.0, 0.0, 1.0}}}, {size, size, 0.6})));
    }
    regions.push_back(
        std::make_unique<ConvexRegion>(std::vector<mesh_map::Plane>{{1, 0.5, 0, -6 - 1.5 * o}}));
    for (std::size_t i = 0; i < regions.size(); ++i) {
      EXPECT_EQ(queries.selectFaces(*regions[i]), mesh_map::selectFaces(*c.bvh, *regions[i]))
          << c.name << ", region " << i;
    }
  }
  const SpatialQueries queries(waves(30), options());
  ASSERT_TRUE(queries.waitForDevice());
  const Count spheres(Query::SPHERE), frusta(Query::FRUSTUM);
  queries.selectFaces(SphereRegion({5, 5, 0}, 2));
  queries.selectFaces(ConvexRegion::box({5, 5, 0}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {1, 1, 1}));
  EXPECT_EQ(spheres(BackEnd::OPENCL), 1u);
  EXPECT_EQ(frusta(BackEnd::OPENCL), 1u);
  EXPECT_EQ(spheres(BackEnd::NATIVE) + frusta(BackEnd::NATIVE), 0u);
}

TEST_F(SpatialQueriesTest, sees_like_the_native_queries)
{
  const auto bvh = soup(400);
  const SpatialQueries queries(bvh, options());
  ASSERT_TRUE(queries.waitForDevice());
  const std::array<double, 3> eye{5, 5, 40};
  // The sides of a frustum that looks down, left, right, bottom and top, and its far end.
  const ConvexRegion view(
      {{8, 0, -1, 0}, {-8, 0, -1, 80}, {0, 8, -1, 0}, {0, -8, -1, 80}, {0, 0, 1, 5}});
  const auto faces = queries.selectFaces(view);
  ASSERT_GT(faces.size(), 50u);
  const mesh_map::RayCast cast = [&](const mesh_map::RayBatch& rays) {
    return mesh_map::castRays(*bvh, rays);
  };
  const Count count(Query::RAY);
  const auto seen = queries.seenFaces(view, faces, eye);
  EXPECT_GT(count(BackEnd::OPENCL), faces.size() / 2);
  EXPECT_EQ(seen, mesh_map::seenFaces(*bvh, view, faces, eye, cast));
  EXPECT_LT(seen.size(), faces.size());
  EXPECT_GT(seen.size(), 10u);
}

TEST_F(SpatialQueriesTest, answers_in_chunks_of_any_size)
{
  const auto bvh = waves(30);
  const SpatialQueries queries(bvh, options());
  ASSERT_TRUE(queries.waitForDevice());
  for (const std::size_t size : {1u, 63u, 64u, 65u, 65535u, 65536u, 65537u, 200001u}) {
    const Questions questions(size);
    EXPECT_TRUE(queries.castRays(questions.rays()) == mesh_map::castRays(*bvh, questions.rays()))
        << size;
  }
}

TEST_F(SpatialQueriesTest, cancels_without_harm)
{
  const auto bvh = waves(30);
  const SpatialQueries queries(bvh, options());
  ASSERT_TRUE(queries.waitForDevice());
  const Questions questions(200000);
  std::atomic<bool> cancel{true};
  mesh_map::BvhOptions run;
  run.cancel = &cancel;
  EXPECT_THROW(queries.castRays(questions.rays(), run), mesh_map::Canceled);
  for (int milliseconds = 0; milliseconds < 5; ++milliseconds) {
    cancel = false;
    std::thread canceller([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      cancel = true;
    });
    EXPECT_THROW(
        while (true) { queries.castRays(questions.rays(), run); }, mesh_map::Canceled);
    canceller.join();
  }
  EXPECT_TRUE(queries.waitForDevice()) << "is no failure of the device";
  EXPECT_TRUE(log_.warnings().empty());
}

TEST_F(SpatialQueriesTest, is_asked_by_several_threads_at_once)
{
  const auto bvh = waves(30);
  const SpatialQueries queries(bvh, options());
  ASSERT_TRUE(queries.waitForDevice());
  const Questions questions(3000);
  const SphereRegion sphere({5, 5, 0}, 2);
  const auto hits = mesh_map::castRays(*bvh, questions.rays());
  const auto faces = mesh_map::selectFaces(*bvh, sphere);
  const Count rays(Query::RAY);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < 5; ++k) {
        wrong += !(queries.castRays(questions.rays()) == hits);
        wrong += queries.selectFaces(sphere) != faces;
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(rays(BackEnd::OPENCL), 4u * 5u * 3000u);
}

TEST_F(SpatialQueriesTest, asks_the_device_where_that_pays)
{
  const auto bvh = waves(10);
  auto with_threshold = options();
  with_threshold.device_threshold = 100;
  const SpatialQueries queries(bvh, with_threshold);
  ASSERT_TRUE(queries.waitForDevice());
  const Count count(Query::RAY);
  queries.castRays(Questions(99).rays());
  EXPECT_EQ(count(BackEnd::OPENCL), 0u);
  queries.castRays(Questions(100).rays());
  EXPECT_EQ(count(BackEnd::OPENCL), 100u);
  queries.castRay({{5, 5, 9}, {0, 0, -1}});
  queries.castRays({});
  EXPECT_EQ(count(BackEnd::OPENCL), 100u);

  auto by_measurement = options();
  by_measurement.device_threshold.reset();
  const SpatialQueries usual(bvh, by_measurement);
  ASSERT_TRUE(usual.waitForDevice());
  usual.castRays(Questions(1).rays());
  EXPECT_EQ(count(BackEnd::OPENCL), 100u) << "one ray never pays";
}

TEST_F(SpatialQueriesTest, throws_what_the_native_queries_throw)
{
  const auto bvh = waves(10);
  const SpatialQueries queries(bvh, options());
  ASSERT_TRUE(queries.waitForDevice());
  const Questions questions(10);
  auto rays = questions.rays();
  rays.origins = {questions.points.data(), 6};
  EXPECT_THROW(queries.castRays(rays), std::invalid_argument);
  EXPECT_THROW(SpatialQueries(nullptr), std::invalid_argument);
  EXPECT_TRUE(log_.warnings().empty());
}
