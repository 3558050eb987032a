#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_map/bvh/rays/bvh_rays.h>

#include "picking/surface_index.h"
#include "selection/face_neighbors.h"
#include "selection/face_selection.h"

using rviz_mesh_plugin::FaceNeighbors;
using rviz_mesh_plugin::joinedCorners;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::SpatialQueries;
using rviz_mesh_plugin::SpatialQueriesOptions;
using rviz_mesh_plugin::SurfaceIndex;
using MeshPtr = std::shared_ptr<MeshData>;

namespace {

/// Takes long to prepare.
constexpr std::uint32_t MANY = 1000;

SpatialQueriesOptions withoutDevice()
{
  SpatialQueriesOptions options;
  options.device = "off";
  return options;
}

/// Waves of 2 cells^2 faces.
MeshPtr waves(std::uint32_t cells)
{
  auto mesh = std::make_shared<MeshData>();
  for (std::uint32_t i = 0; i <= cells; ++i) {
    for (std::uint32_t j = 0; j <= cells; ++j) {
      const float x = 10.0f * i / cells, y = 10.0f * j / cells;
      mesh->vertices.push_back({{x, y, std::sin(x) * std::cos(y)}, {}});
    }
  }
  for (std::uint32_t i = 0; i < cells; ++i) {
    for (std::uint32_t j = 0; j < cells; ++j) {
      const std::uint32_t a = i * (cells + 1) + j, b = a + cells + 1;
      mesh->indices.insert(mesh->indices.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
  }
  return mesh;
}

bool waitUntil(const std::function<bool()>& done)
{
  for (int i = 0; i < 30000 && !done(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return done();
}

SurfaceIndex::State ready(SurfaceIndex& index, const MeshPtr& mesh)
{
  waitUntil([&] {
    const auto state = index.find(mesh);
    return state.queries || !state.failure.empty();
  });
  return index.find(mesh);
}

}  // namespace

TEST(SurfaceIndexTest, answers_as_the_hierarchy_of_the_mesh_does)
{
  SurfaceIndex index(withoutDevice());
  const auto mesh = waves(50);
  const auto state = ready(index, mesh);
  ASSERT_TRUE(state.queries);
  EXPECT_EQ(state.progress, 1.0f);
  EXPECT_EQ(state.failure, "");
  std::vector<float> positions;
  for (const auto& vertex : mesh->vertices) {
    positions.insert(positions.end(), vertex.position.begin(), vertex.position.end());
  }
  const auto bvh = mesh_map::Bvh::build({positions, mesh->indices});
  std::size_t hits = 0;
  for (int i = 0; i < 300; ++i) {
    const mesh_map::Ray ray{{0.04 * i, 5.0, 5.0}, {0.3 * std::sin(i), 0.2 * std::cos(3.0 * i), -1}};
    const auto expected = mesh_map::castRay(bvh, ray);
    const auto hit = state.queries->castRay(ray);
    ASSERT_EQ(hit.face, expected.face);
    ASSERT_EQ(hit.distance, expected.distance);
    hits += hit.face != mesh_map::NO_INDEX;
  }
  EXPECT_GT(hits, 150u);
  EXPECT_EQ(index.meshCount(), 1u);
}

TEST(SurfaceIndexTest, all_who_ask_share_what_is_made_once)
{
  SurfaceIndex index(withoutDevice());
  const auto mesh = waves(200), other = waves(20);
  std::vector<std::shared_ptr<const SpatialQueries>> found(4);
  std::vector<std::shared_ptr<const FaceNeighbors>> neighbors(4);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < found.size(); ++i) {
    threads.emplace_back([&, i] {
      const auto& asked = i % 2 == 0 ? mesh : other;
      found[i] = ready(index, asked).queries;
      waitUntil([&] { return index.findNeighbors(asked).neighbors != nullptr; });
      neighbors[i] = index.findNeighbors(asked).neighbors;
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  ASSERT_TRUE(found[0] && found[1] && neighbors[0] && neighbors[1]);
  EXPECT_EQ(found[0], found[2]);
  EXPECT_EQ(found[1], found[3]);
  EXPECT_NE(found[0], found[1]);
  EXPECT_EQ(neighbors[0], neighbors[2]);
  EXPECT_EQ(found[0]->bvh().faceCount(), mesh->faceCount());
  EXPECT_EQ(found[1]->bvh().faceCount(), other->faceCount());
  const FaceNeighbors expected(joinedCorners(*mesh));
  for (std::uint32_t face = 0; face < mesh->faceCount(); face += 7) {
    rviz_mesh_plugin::FaceSelection one(mesh->faceCount());
    one.select({face});
    ASSERT_EQ(neighbors[0]->grow(one.bits()), expected.grow(one.bits()));
  }
  EXPECT_EQ(index.meshCount(), 2u);
}

TEST(SurfaceIndexTest, progress_is_told_and_never_falls)
{
  SurfaceIndex index(withoutDevice());
  const auto mesh = waves(MANY);
  float last = 0.0f;
  std::size_t steps = 0;
  EXPECT_TRUE(waitUntil([&] {
    const auto state = index.find(mesh);
    EXPECT_GE(state.progress, last);
    EXPECT_LE(state.progress, 1.0f);
    steps += state.progress > last;
    last = state.progress;
    return state.queries != nullptr;
  }));
  EXPECT_EQ(last, 1.0f);
  EXPECT_GE(steps, 3u);
}

TEST(SurfaceIndexTest, work_for_a_mesh_that_goes_is_given_up_and_does_not_keep_it)
{
  SurfaceIndex index(withoutDevice());
  auto mesh = waves(MANY);
  const std::weak_ptr<MeshData> watched = mesh;
  ASSERT_TRUE(waitUntil([&] { return index.find(mesh).progress > 0.0f; }));
  ASSERT_FALSE(index.find(mesh).queries) << "the mesh is too small for this test";
  mesh.reset();
  EXPECT_TRUE(watched.expired()) << "only its copying keeps it";
  EXPECT_TRUE(waitUntil([&] { return index.givenUp() == 1; }));
  EXPECT_EQ(index.meshCount(), 0u);
  const auto other = waves(5);
  EXPECT_TRUE(ready(index, other).queries) << "the next one is not held up";
}

TEST(SurfaceIndexTest, a_mesh_that_goes_before_its_turn_costs_nothing)
{
  SurfaceIndex index(withoutDevice());
  const auto first = waves(MANY / 2);
  auto second = waves(5);
  index.find(first);
  index.find(second);
  index.findNeighbors(second);
  second.reset();
  EXPECT_TRUE(ready(index, first).queries);
  EXPECT_TRUE(waitUntil([&] { return index.givenUp() == 2; }));
}

TEST(SurfaceIndexTest, what_was_made_goes_with_the_mesh_or_its_last_user)
{
  SurfaceIndex index(withoutDevice());
  auto mesh = waves(10), other = waves(10);
  const std::weak_ptr<const SpatialQueries> watched = ready(index, mesh).queries;
  const auto used = ready(index, other).queries;
  EXPECT_FALSE(watched.expired());
  mesh.reset();
  other.reset();
  EXPECT_TRUE(waitUntil([&] { return watched.expired() && used.use_count() == 1; }));
  EXPECT_EQ(used->bvh().faceCount(), 200u);
  EXPECT_EQ(index.meshCount(), 0u);
}

TEST(SurfaceIndexTest, a_failure_says_why_and_stops_nobody_else)
{
  SurfaceIndex index(withoutDevice());
  const auto empty = std::make_shared<MeshData>();
  const auto broken = waves(3);
  broken->vertices[4].position[1] = std::numeric_limits<float>::quiet_NaN();
  const auto good = waves(3);
  for (const auto& mesh : {empty, broken}) {
    const auto state = ready(index, mesh);
    EXPECT_FALSE(state.queries);
    EXPECT_NE(state.failure, "");
    EXPECT_EQ(index.find(mesh).failure, state.failure);
  }
  EXPECT_TRUE(ready(index, good).queries);
  const auto beyond = waves(3);
  beyond->indices[7] = 4000000000;
  beyond->vertices.resize(2);
  EXPECT_NE(ready(index, beyond).failure, "");
}

TEST(SurfaceIndexTest, it_may_go_at_any_moment)
{
  const auto mesh = waves(300);
  for (int i = 0; i < 20; ++i) {
    SurfaceIndex index(withoutDevice());
    index.find(mesh);
    index.findNeighbors(mesh);
    std::this_thread::sleep_for(std::chrono::milliseconds(i));
    if (i % 2 == 0) {
      index.clear();
      EXPECT_EQ(index.meshCount(), 0u);
    }
  }
  SurfaceIndex& shared = SurfaceIndex::instance();
  EXPECT_EQ(&shared, &SurfaceIndex::instance());
  auto user = shared.user(), another = shared.user();
  shared.find(mesh);
  EXPECT_EQ(shared.meshCount(), 1u);
  user.reset();
  EXPECT_EQ(shared.meshCount(), 1u);
  another.reset();
  EXPECT_EQ(shared.meshCount(), 0u) << "with the last user";
}
