#include <mesh_map/bvh/tree/back_end.h>

#include <gtest/gtest.h>

#include <limits>
#include <thread>
#include <vector>

using mesh_map::BackEnd;
using mesh_map::Query;

namespace {

constexpr BackEnd ALL_BACK_ENDS[] = {BackEnd::NATIVE, BackEnd::OPENCL};
constexpr Query ALL_QUERIES[] = {Query::RAY, Query::CLOSEST_POINT, Query::SPHERE, Query::FRUSTUM,
                                 Query::LASSO};
constexpr std::size_t NEVER = std::numeric_limits<std::size_t>::max();

std::vector<std::uint64_t> allCounts()
{
  std::vector<std::uint64_t> counts;
  for (const BackEnd back_end : ALL_BACK_ENDS) {
    for (const Query query : ALL_QUERIES) {
      counts.push_back(queryCount(back_end, query));
    }
  }
  return counts;
}

TEST(BackEnd, CountsEachQueryOfEachBackEndApart)
{
  std::size_t which = 0;
  for (const BackEnd back_end : ALL_BACK_ENDS) {
    for (const Query query : ALL_QUERIES) {
      std::vector<std::uint64_t> expected = allCounts();
      expected[which] += 5'000'000'000 + which;  // more than 32 bits hold
      countQueries(back_end, query, 5'000'000'000 + which);
      EXPECT_EQ(allCounts(), expected) << which;
      ++which;
    }
  }
  EXPECT_EQ(which, mesh_map::BACK_ENDS * mesh_map::QUERIES);
}

TEST(BackEnd, LosesNoCountOfThreads)
{
  const std::uint64_t before = queryCount(BackEnd::NATIVE, Query::RAY);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([] {
      for (int k = 0; k < 10'000; ++k) {
        countQueries(BackEnd::NATIVE, Query::RAY, 3);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(queryCount(BackEnd::NATIVE, Query::RAY), before + 4 * 10'000 * 3);
}

TEST(BackEnd, GpusAloneGetLargeBatches)
{
  for (const bool gpu : {false, true}) {
    for (const Query query : ALL_QUERIES) {
      EXPECT_GT(mesh_map::deviceThreshold(query, gpu), 1u);  // one query is faster natively
    }
    EXPECT_EQ(mesh_map::deviceThreshold(Query::LASSO, gpu), NEVER);  // has no kernel
  }
  // another program on the cores that native code has gains nothing
  for (const Query query : ALL_QUERIES) {
    EXPECT_EQ(mesh_map::deviceThreshold(query, false), NEVER);
  }
  // a picture of a visible-first selection goes to any GPU
  EXPECT_LE(mesh_map::deviceThreshold(Query::RAY, true), 100u * 80u);
  EXPECT_LT(mesh_map::deviceThreshold(Query::CLOSEST_POINT, true), 1'000'000u);
  EXPECT_LT(mesh_map::deviceThreshold(Query::SPHERE, true), NEVER);
  EXPECT_LT(mesh_map::deviceThreshold(Query::FRUSTUM, true), NEVER);
}

}  // namespace
