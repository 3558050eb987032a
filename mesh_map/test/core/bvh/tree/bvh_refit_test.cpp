#include <mesh_map/bvh/tree/bvh.h>

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "bvh_checks.h"

using mesh_map::Bvh;
using mesh_map::BvhOptions;

namespace {

using Move = std::function<void(std::vector<float>& positions)>;

struct NamedMove
{
  std::string name;
  Move move;
};

std::vector<NamedMove> moves()
{
  return {
      {"nothing", [](std::vector<float>&) {}},
      {"a little",
       [](std::vector<float>& positions) {
         std::mt19937 random(5);
         std::normal_distribution<float> step(0.0f, 0.1f);
         for (float& value : positions) {
           value += step(random);
         }
       }},
      {"far away",
       [](std::vector<float>& positions) {
         for (float& value : positions) {
           value = 3e7f - value;
         }
       }},
      {"to the largest numbers",
       [](std::vector<float>& positions) {
         for (std::size_t i = 0; i < positions.size(); ++i) {
           positions[i] = i % 2 == 0 ? std::numeric_limits<float>::max()
                                     : std::numeric_limits<float>::lowest();
         }
       }},
      {"into a point",
       [](std::vector<float>& positions) { positions.assign(positions.size(), 3); }},
      {"one vertex",
       [](std::vector<float>& positions) { positions[positions.size() / 6 * 3] = -1e9f; }},
  };
}

std::string refusal(Bvh& bvh, const TestMesh& mesh)
{
  try {
    bvh.refit(mesh.view());
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST(BvhRefit, IsRightWhereverVerticesMove)
{
  std::vector<TestMesh> meshes = testMeshes();
  meshes.push_back(terrain(150));
  for (const TestMesh& before : meshes) {
    for (const NamedMove& move : moves()) {
      SCOPED_TRACE(before.name + ", " + move.name);
      const Bvh built = Bvh::build(before.view());
      TestMesh after = before;
      move.move(after.positions);
      Bvh bvh = built;
      bvh.refit(after.view());
      EXPECT_EQ(whatIsWrong(bvh, after), "");
      ASSERT_EQ(bvh.nodes().size(), built.nodes().size());
      EXPECT_EQ(bvh.center(), built.center());
      for (std::size_t i = 0; i < built.nodes().size(); ++i) {
        const mesh_map::BvhNode &a = bvh.nodes()[i], &b = built.nodes()[i];
        ASSERT_EQ(std::memcmp(a.child, b.child, sizeof(a.child) + sizeof(a.count)), 0);
      }
      // Boxes do not remember where the vertices have been.
      bvh.refit(before.view());
      EXPECT_TRUE(sameTree(bvh, built));
    }
  }
}

TEST(BvhRefit, IsTheSameOnAnyNumberOfThreads)
{
  const TestMesh before = terrain(150);
  TestMesh after = before;
  moves()[1].move(after.positions);
  Bvh one = Bvh::build(before.view());
  Bvh bvh = one;
  BvhOptions options;
  options.threads = 1;
  one.refit(after.view(), options);
  for (const unsigned threads : {2u, 3u, 8u}) {
    options.threads = threads;
    bvh.refit(before.view());
    bvh.refit(after.view(), options);
    EXPECT_TRUE(sameTree(one, bvh)) << threads;
  }
}

TEST(BvhRefit, ChangesNothingWhereItRefuses)
{
  const TestMesh before = terrain(150);
  Bvh bvh = Bvh::build(before.view());
  const Bvh built = bvh;

  TestMesh mesh = before;
  mesh.positions[3 * 777 + 1] = NAN;
  EXPECT_NE(refusal(bvh, mesh).find("has vertex 777 at ("), std::string::npos);
  mesh = before;
  mesh.faces[3 * 5] = 1000000;
  EXPECT_EQ(refusal(bvh, mesh).find("face 5 refers to vertex 1000000"), 0u);
  EXPECT_EQ(refusal(bvh, terrain(149)),
            "the mesh has 44402 faces, but the spatial index is one of 45000: build a new one "
            "where faces have changed");
  EXPECT_EQ(refusal(bvh, {"", {}, {}}),
            "the mesh has 0 faces, but the spatial index is one of 45000: build a new one where "
            "faces have changed");

  mesh = before;
  moves()[1].move(mesh.positions);
  std::atomic<bool> cancel{true};
  BvhOptions options;
  options.cancel = &cancel;
  EXPECT_THROW(bvh.refit(mesh.view(), options), mesh_map::Canceled);
  cancel = false;
  options.progress = [&](double fraction) { cancel = fraction > 0.5; };
  EXPECT_THROW(bvh.refit(mesh.view(), options), mesh_map::Canceled);
  EXPECT_TRUE(sameTree(bvh, built));
}

TEST(BvhRefit, TellsItsProgress)
{
  const TestMesh mesh = terrain(150);
  Bvh bvh = Bvh::build(mesh.view());
  std::vector<double> told;
  BvhOptions options;
  options.threads = 3;
  options.progress = [&](double fraction) { told.push_back(fraction); };
  bvh.refit(mesh.view(), options);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GE(told.size(), 5u);
  EXPECT_EQ(told.back(), 1.0);
}
