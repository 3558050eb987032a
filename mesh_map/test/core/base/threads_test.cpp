// What threads do at the same time: the same answers from any number of them, and from many callers
// at once. With ThreadSanitizer this is the proof that they do not race.
#include <mesh_map/base/parallel.h>
#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/tree/back_end.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/support/test_meshes.h"

using mesh_map::Bvh;
using mesh_map::BvhOptions;

namespace {

constexpr std::size_t COUNT = 5000;  // rays and points: several chunks for each of 8 threads

BvhOptions onThreads(unsigned threads)
{
  BvhOptions options;
  options.threads = threads;
  return options;
}

/// Rays downwards from above the terrain, tilted, some of which miss it.
struct Questions
{
  std::vector<double> origins, directions;

  Questions()
  {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-1.0, 11.0), tilt(-0.5, 0.5);
    for (std::size_t i = 0; i < COUNT; ++i) {
      origins.insert(origins.end(), {place(random), place(random), 5.0});
      directions.insert(directions.end(), {tilt(random), tilt(random), -1.0});
    }
  }
  mesh_map::RayBatch rays() const { return {origins, directions, {}}; }
};

struct Answers
{
  mesh_map::RayHits hits;
  std::vector<std::uint8_t> any;
  mesh_map::SurfaceHits closest;
  std::vector<std::uint32_t> touched;

  Answers(const Bvh& bvh, const Questions& questions, unsigned threads)
      : hits(castRays(bvh, questions.rays(), {}, onThreads(threads))),
        any(raysHitAny(bvh, questions.rays(), {}, onThreads(threads))),
        closest(closestPoints(bvh, questions.origins, {}, onThreads(threads))),
        touched(selectFaces(bvh, mesh_map::SphereRegion({5.0, 5.0, 0.0}, 2.0)))
  {
  }

  bool operator==(const Answers& other) const
  {
    return hits.faces == other.hits.faces && hits.distances == other.hits.distances &&
           any == other.any && closest.faces == other.closest.faces &&
           closest.distances == other.closest.distances &&
           closest.positions == other.closest.positions && touched == other.touched;
  }
};

TEST(Threads, AnyNumberBuildsAndAnswersAlike)
{
  const TestMesh mesh = terrain(100);
  const Questions questions;
  const Answers expected(Bvh::build(mesh.view(), onThreads(1)), questions, 1);
  EXPECT_GT(expected.touched.size(), 100u);
  for (const unsigned threads : {3u, 8u}) {
    Bvh bvh = Bvh::build(mesh.view(), onThreads(threads));
    EXPECT_TRUE(Answers(bvh, questions, threads) == expected) << threads << " threads";
    bvh.refit(mesh.view(), onThreads(threads));
    EXPECT_TRUE(Answers(bvh, questions, threads) == expected) << threads << " threads, refitted";
  }
}

TEST(Threads, ManyCallersMayAskAtOnce)
{
  const TestMesh mesh = terrain(60);
  const Bvh bvh = Bvh::build(mesh.view());
  const Questions questions;
  const Answers expected(bvh, questions, 1);
  const auto before = queryCount(mesh_map::BackEnd::OPENCL, mesh_map::Query::LASSO);
  std::atomic<int> same{0};
  std::vector<std::thread> callers;
  for (unsigned i = 0; i < 4; ++i) {
    callers.emplace_back([&] {
      same += Answers(bvh, questions, 2) == expected;
      for (unsigned k = 0; k < 1000; ++k) {
        countQueries(mesh_map::BackEnd::OPENCL, mesh_map::Query::LASSO, 3);
      }
    });
  }
  for (std::thread& caller : callers) {
    caller.join();
  }
  EXPECT_EQ(same, 4);
  EXPECT_EQ(queryCount(mesh_map::BackEnd::OPENCL, mesh_map::Query::LASSO) - before, 12000u);
}

TEST(Threads, ProgressIsToldInOrderAndByOneAtATime)
{
  const TestMesh mesh = terrain(150);
  std::vector<double> told;  // by whichever thread, without a lock
  BvhOptions options = onThreads(4);
  options.progress = [&](double fraction) { told.push_back(fraction); };
  Bvh::build(mesh.view(), options);
  ASSERT_FALSE(told.empty());
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GE(told.front(), 0.0);
  EXPECT_EQ(told.back(), 1.0);
}

TEST(Threads, AnotherThreadMayCancelAtAnyTime)
{
  const TestMesh mesh = terrain(150);
  const Questions questions;
  const Answers expected(Bvh::build(mesh.view()), questions, 1);
  for (unsigned microseconds = 0; microseconds < 30000; microseconds += 1500) {
    std::atomic<bool> cancel{false};
    BvhOptions options = onThreads(4);
    options.cancel = &cancel;
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
      cancel = true;
    });
    try {
      const Bvh bvh = Bvh::build(mesh.view(), options);
      const auto hits = castRays(bvh, questions.rays(), {}, options);
      EXPECT_EQ(hits.faces, expected.hits.faces);
      const auto closest = closestPoints(bvh, questions.origins, {}, options);
      EXPECT_EQ(closest.faces, expected.closest.faces);
    } catch (const mesh_map::Canceled&) {
      EXPECT_TRUE(cancel);
    }
    other.join();
  }
}

TEST(Threads, AnErrorInOneEndsTheLoopAndArrives)
{
  std::atomic<std::size_t> done{0};
  const auto worker = [&]() -> mesh_map::RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      if (begin <= 700 && 700 < end) {
        throw std::runtime_error("item 700");
      }
      done += end - begin;
    };
  };
  EXPECT_THROW(mesh_map::parallelFor(10000, 10, 4, worker), std::runtime_error);
  EXPECT_LT(done, 10000u);
}

/// Nicenesses above that of the caller, and threads, of those that ran a loop of so many threads.
std::pair<std::set<int>, std::set<std::thread::id>> whoRuns(unsigned threads)
{
  const auto niceness = [] {
    return getpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)));
  };
  const int own = niceness();
  std::mutex mutex;
  std::pair<std::set<int>, std::set<std::thread::id>> found;
  std::atomic<std::size_t> sum{0};
  mesh_map::parallelEach(1000, 10, threads, [&](std::size_t i) {
    sum += i;
    const std::lock_guard<std::mutex> lock(mutex);
    found.first.insert(niceness() - own);
    found.second.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(sum, 499500u);
  EXPECT_EQ(niceness(), own);
  return found;
}

TEST(Threads, LoopsInTheBackgroundRunInThreadsOfLowerPriority)
{
  const auto self = std::this_thread::get_id();
  const int most = 19 - getpriority(PRIO_PROCESS, 0);  // of a test that is run with less already
  const std::set<int> lower{std::min(10, most)};
  for (const unsigned threads : {1u, 3u}) {
    {
      const mesh_map::BackgroundLoops background;
      const auto found = whoRuns(threads);
      EXPECT_EQ(found.first, lower);
      EXPECT_EQ(found.second.count(self), 0u);
      EXPECT_LE(found.second.size(), threads);
      {
        const mesh_map::BackgroundLoops inner;
      }
      EXPECT_EQ(whoRuns(threads).first, lower);
      std::thread other([threads] { EXPECT_EQ(whoRuns(threads).first, std::set<int>{0}); });
      other.join();  // which is none of its callers
    }
    EXPECT_EQ(whoRuns(threads).first, std::set<int>{0});
  }
  EXPECT_EQ(whoRuns(1).second, std::set<std::thread::id>{self});
}

TEST(Threads, AnErrorInTheBackgroundArrives)
{
  const mesh_map::BackgroundLoops background;
  const auto fail = [](std::size_t) { throw std::runtime_error("an item"); };
  EXPECT_THROW(mesh_map::parallelEach(10, 1, 1, fail), std::runtime_error);
}

}  // namespace
