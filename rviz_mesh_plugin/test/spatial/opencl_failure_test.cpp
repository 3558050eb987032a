#include <atomic>
#include <fstream>
#include <set>
#include <thread>

#include "failing_opencl.h"
#include "query_fixture.h"

using query_test::Log;
using query_test::Questions;
using query_test::TemporaryFolder;
using query_test::waves;
using rviz_mesh_plugin::SpatialQueries;

namespace {

class OpenClFailureTest : public query_test::DeviceTest
{
 protected:
  void TearDown() override
  {
    failing_opencl::stop();
    failing_opencl::claimMemory(0, 0);
    failing_opencl::answerNothing(false);
    failing_opencl::holdBuilds(false);
  }

  /// Asks everything; whatever the device does, the answers are the native ones.
  void expectRightAnswers(const SpatialQueries& queries, const std::string& when)
  {
    EXPECT_TRUE(queries.castRays(questions_.rays()) == hits_) << when;
    EXPECT_EQ(queries.selectFaces(sphere_), faces_) << when;
  }

  const query_test::BvhPtr bvh_ = waves(10);
  const Questions questions_{200};
  const mesh_map::SphereRegion sphere_{{5, 5, 0}, 2};
  const mesh_map::RayHits hits_ = mesh_map::castRays(*bvh_, questions_.rays());
  const std::vector<std::uint32_t> faces_ = mesh_map::selectFaces(*bvh_, sphere_);
};

}  // namespace

TEST_F(OpenClFailureTest, a_start_that_fails_at_any_call_is_at_most_one_warning)
{
  std::set<std::string> failed;
  int refused = 0;
  for (const bool forever : {false, true}) {
    for (long k = 0;; k += forever ? 7 : 1) {
      const TemporaryFolder cache;  // also makes the device another one, that has not failed yet
      const Log log;
      auto options = this->options();
      options.cache_folder = cache.path();
      options.log = log.function();
      failing_opencl::failAt(k, forever);
      const SpatialQueries queries(bvh_, options);
      const bool ready = queries.waitForDevice();
      failing_opencl::stop();
      const std::string name = failing_opencl::failed();
      expectRightAnswers(queries, name + " failed, call " + std::to_string(k));
      EXPECT_EQ(log.warnings().size(), ready ? 0u : 1u) << k;
      if (name.empty()) {
        EXPECT_TRUE(ready);
        break;
      }
      failed.insert(name);
      refused += !ready;
      if (log.infos().empty() && !log.warnings().empty()) {
        EXPECT_EQ(log.warnings()[0].rfind("OpenCL: ", 0), 0u) << log.warnings()[0];
        const SpatialQueries again(bvh_, options);
        EXPECT_FALSE(again.waitForDevice()) << "one that does not start is not asked again";
        EXPECT_EQ(log.warnings().size(), 1u);
      }
    }
  }
  EXPECT_GE(failed.size(), 15u) << "kinds of calls that failed";
  EXPECT_GT(refused, 50);
}

TEST_F(OpenClFailureTest, a_query_that_fails_at_any_call_goes_on_natively)
{
  const Questions many(70000);  // two chunks
  const auto expected = mesh_map::castRays(*bvh_, many.rays());
  std::set<std::string> failed;
  for (const bool forever : {false, true}) {
    for (long k = 0;; ++k) {
      const Log log;
      auto options = this->options();
      options.log = log.function();
      const SpatialQueries queries(bvh_, options), other(bvh_, options);
      ASSERT_TRUE(queries.waitForDevice()) << "starts anew after a failure";
      ASSERT_TRUE(other.waitForDevice());
      failing_opencl::failAt(k, forever);
      EXPECT_TRUE(queries.castRays(many.rays()) == expected) << k;
      expectRightAnswers(queries, "call " + std::to_string(k));
      failing_opencl::stop();
      const std::string name = failing_opencl::failed();
      if (name.empty()) {
        EXPECT_TRUE(log.warnings().empty());
        break;
      }
      failed.insert(name);
      EXPECT_EQ(log.warnings().size(), 1u) << name;
      EXPECT_FALSE(queries.waitForDevice()) << name;
      EXPECT_FALSE(other.waitForDevice()) << "it is the same device";
      expectRightAnswers(other, name);
      EXPECT_EQ(log.warnings().size(), 1u);
    }
  }
  EXPECT_GE(failed.size(), 7u) << "kinds of calls that failed";
}

TEST_F(OpenClFailureTest, a_selection_of_few_faces_neither_uploads_the_mesh_nor_asks_the_device)
{
  auto options = this->options();
  options.device_threshold = 2000;
  const SpatialQueries first(bvh_, options);  // starts the device, which all share
  ASSERT_TRUE(first.waitForDevice());
  const auto large = waves(70);
  const SpatialQueries queries(large, options);
  const mesh_map::SphereRegion small({5, 5, 0}, 0.5), all({5, 5, 0}, 10.0);
  ASSERT_LT(queries.mostFaces(small), 2000u);
  failing_opencl::failAt(1 << 20);
  EXPECT_EQ(queries.selectFaces(small), mesh_map::selectFaces(*large, small));
  EXPECT_EQ(failing_opencl::stop(), 0) << "calls";
  failing_opencl::failAt(1 << 20);
  EXPECT_EQ(queries.selectFaces(all), mesh_map::selectFaces(*large, all));
  EXPECT_GT(failing_opencl::stop(), 0);
}

TEST_F(OpenClFailureTest, a_device_that_answers_nonsense_is_not_used)
{
  failing_opencl::answerNothing(true);
  const SpatialQueries queries(bvh_, options());
  EXPECT_FALSE(queries.waitForDevice());
  expectRightAnswers(queries, "nonsense");
  ASSERT_EQ(log_.warnings().size(), 1u);
  EXPECT_NE(log_.warnings()[0].find("wrongly"), std::string::npos) << log_.warnings()[0];
}

TEST_F(OpenClFailureTest, a_mesh_too_large_for_the_device_is_one_warning_and_other_meshes_go_on)
{
  // A corner has 12 bytes: room for 5000 faces in a buffer, or batches and a few faces in all.
  const unsigned long claims[][2] = {{180000, 1ul << 34}, {1ul << 32, 3ul << 20}};
  for (const auto& claim : claims) {
    failing_opencl::claimMemory(claim[0], claim[1]);
    const TemporaryFolder cache;
    const Log log;
    auto options = this->options();
    options.cache_folder = cache.path();
    options.log = log.function();
    const auto large = waves(70);
    const SpatialQueries queries(large, options);
    EXPECT_FALSE(queries.waitForDevice());
    const auto expected = mesh_map::castRays(*large, questions_.rays());
    for (int i = 0; i < 3; ++i) {
      EXPECT_TRUE(queries.castRays(questions_.rays()) == expected);
    }
    ASSERT_EQ(log.warnings().size(), 1u);
    EXPECT_NE(log.warnings()[0].find("a mesh of 9800 faces needs"), std::string::npos);
    if (claim[1] > 1ul << 30) {
      const SpatialQueries small(bvh_, options);
      EXPECT_TRUE(small.waitForDevice());
      EXPECT_EQ(log.warnings().size(), 1u);
    }
  }
}

TEST_F(OpenClFailureTest, a_log_may_ask_back_and_throw_anything)
{
  failing_opencl::claimMemory(180000, 1ul << 34);
  auto options = this->options();
  const auto large = waves(70);
  const auto expected = mesh_map::castRays(*large, questions_.rays());
  const SpatialQueries* asked = nullptr;
  int warnings = 0;  // the second line, in this thread
  options.log = [&](rviz_mesh_plugin::LogLevel level, const std::string&) {
    if (level == rviz_mesh_plugin::LogLevel::WARNING) {
      ++warnings;
      EXPECT_TRUE(asked->castRays(questions_.rays()) == expected);
    }
    throw 1;
  };
  const SpatialQueries queries(large, options);
  asked = &queries;
  EXPECT_FALSE(queries.waitForDevice());
  EXPECT_EQ(warnings, 1);
}

TEST_F(OpenClFailureTest, answers_natively_until_the_device_is_ready)
{
  failing_opencl::holdBuilds(true);
  const SpatialQueries queries(bvh_, options());
  const auto before = mesh_map::queryCount(mesh_map::BackEnd::OPENCL, mesh_map::Query::RAY);
  expectRightAnswers(queries, "while it compiles");
  EXPECT_EQ(mesh_map::queryCount(mesh_map::BackEnd::OPENCL, mesh_map::Query::RAY), before);
  failing_opencl::holdBuilds(false);
  EXPECT_TRUE(queries.waitForDevice());
}

TEST_F(OpenClFailureTest, ends_safely_while_the_device_starts)
{
  for (const int delay : {0, 1, 2, 5, 10, 20, 50}) {
    const TemporaryFolder cache;
    auto options = this->options();
    options.cache_folder = cache.path();
    auto queries = std::make_unique<SpatialQueries>(bvh_, options);
    std::this_thread::sleep_for(std::chrono::milliseconds(delay));
    queries.reset();
  }
  failing_opencl::holdBuilds(true);
  auto queries = std::make_unique<SpatialQueries>(bvh_, options());
  std::thread release([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    failing_opencl::holdBuilds(false);
  });
  queries.reset();
  release.join();
  EXPECT_TRUE(log_.warnings().empty()) << "whom it no longer concerns";
}
