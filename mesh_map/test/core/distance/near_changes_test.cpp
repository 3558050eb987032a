// Where obstacles have changed, and which vertices are looked at therefore.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "base/unique.h"
#include "core/support/front_checks.h"
#include "distance/obstacles/near_changes.h"

namespace mesh_map {
namespace {

constexpr double REACH = 0.5, EDGE = 0.2;

/// As numbered, and with vertices beside each other in memory anywhere.
std::vector<TestMesh> planes()
{
  TestMesh mesh = plane(200, 0.24);
  TestMesh mixed = mesh;
  mixed.name = "mixed";
  const std::size_t size = mesh.positions.size() / 3;
  std::vector<std::uint32_t> order(size);
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  for (std::size_t v = 0; v < size; ++v) {
    std::copy_n(mesh.positions.begin() + 3 * v, 3, mixed.positions.begin() + 3 * order[v]);
  }
  for (std::uint32_t& v : mixed.faces) {
    v = order[v];
  }
  return {mesh, mixed};
}

TEST(NearChanges, BlocksHoldEachVertexOnceInTheirBoxes)
{
  for (const TestMesh& mesh : planes()) {
    const FrontSample sample(mesh);
    VertexParts parts(*sample.front, 0.5);
    parts.sort();
    ASSERT_GT(parts.size(), 1u);
    std::vector<unsigned> visits(sample.size());
    for (std::size_t part = 0; part < parts.size(); ++part) {
      parts.forEachBlock(part, [&](const VertexBox& box, ArrayView<std::uint32_t> vertices) {
        for (const std::uint32_t v : vertices) {
          ++visits[v];
          EXPECT_TRUE(parts.isIn(v, part));
          for (unsigned axis = 0; axis < 3; ++axis) {
            EXPECT_LE(box.lowest[axis], mesh.positions[3 * v + axis]);
            EXPECT_GE(box.highest[axis], mesh.positions[3 * v + axis]);
          }
        }
      });
    }
    EXPECT_EQ(visits, std::vector<unsigned>(sample.size(), 1));
  }
}

/// What is near is looked at, and nearly nothing else where vertices lie together in memory.
TEST(NearChanges, BoxesAreNearWhereAnyOfTheirVerticesIs)
{
  for (const TestMesh& mesh : planes()) {
    const FrontSample sample(mesh);
    VertexParts parts(*sample.front, 0.5);
    parts.sort();
    for (const unsigned count : {1u, 20u, 500u}) {
      std::vector<std::uint8_t> lethal = randomMask(sample.size(), 0.01, count);
      std::mt19937 random(count);
      std::vector<std::uint32_t> changed;
      for (unsigned i = 0; i < count; ++i) {
        changed.push_back(static_cast<std::uint32_t>(random() % sample.size()));
      }
      makeUnique(changed);
      const NearChanges near(*sample.front, changed, lethal, REACH);
      std::size_t seen = 0, missed = 0, wrong = 0;
      for (std::size_t part = 0; part < parts.size(); ++part) {
        parts.forEachBlock(part, [&](const VertexBox& box, ArrayView<std::uint32_t> vertices) {
          const bool is_near = near.isNear(box, EDGE);
          seen += is_near ? vertices.size() : 0;
          for (const std::uint32_t v : vertices) {
            double distance = FAR;
            for (const std::uint32_t u : changed) {
              distance = std::min(distance, between(mesh, u, v));
            }
            missed += !is_near && distance <= REACH + EDGE ? 1 : 0;
            const double told = near.distance(v);  // boxes of changes may be nearer than these
            wrong += told > std::max(distance * (1.0 + 1e-6), 0.5 * REACH) && distance <= REACH;
          }
        });
      }
      EXPECT_EQ(missed, 0u) << count;
      EXPECT_EQ(wrong, 0u) << count;
      if (count == 1 && mesh.name != "mixed") {
        EXPECT_LT(seen, sample.size() / 10);
      }
    }
  }
}

}  // namespace
}  // namespace mesh_map
