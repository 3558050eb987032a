// Costs under footprints, and what is no footprint. Also with sanitizers.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/support/test_meshes.h"
#include "paths/footprint.h"

namespace {

using mesh_map::Bvh;
using mesh_map::Footprint;
using mesh_map::FootprintCosts;

const std::vector<double> AT_5_5 = {1, 0, 0, 5, 0, 1, 0, 5, 0, 0, 1, 0};

Footprint square(double half)
{
  return {{{half, -half}, {half, half}, {-half, half}, {-half, -half}}, -2.0, 2.0};
}

Footprint circle(double radius, int corners)
{
  Footprint footprint{{}, -2.0, 2.0};
  for (int i = 0; i < corners; ++i) {
    const double angle = 6.283185307179586 * i / corners;
    footprint.corners.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return footprint;
}

/// A flat square of 10 m whose costs are x.
struct Ground
{
  TestMesh mesh = terrain(50);
  std::vector<float> costs;

  Ground()
  {
    for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
      costs.push_back(mesh.positions[i]);
      mesh.positions[i + 2] = 0.0f;
    }
  }

  FootprintCosts under(const Footprint& footprint, const std::vector<double>& poses = AT_5_5) const
  {
    return footprintCosts(Bvh::build(mesh.view()), mesh.view(), costs, footprint, poses);
  }
};

TEST(Footprint, tells_the_largest_cost_anywhere_under_it)
{
  const Ground ground;
  const FootprintCosts found = ground.under(square(0.33));
  EXPECT_NEAR(found.max_costs[0], 5.33, 1e-5);  // within a face, not at a vertex
  EXPECT_EQ(found.ground[0], 1.0);
  EXPECT_FALSE(found.lethal[0] || found.unknown[0]);
  for (const int corners : {3, 14, 15, 16, 40, 200}) {
    EXPECT_NEAR(ground.under(circle(0.5, corners)).max_costs[0], 5.5, 1e-5) << corners;
    EXPECT_EQ(ground.under(circle(0.5, corners)).ground[0], 1.0) << corners;
  }
}

TEST(Footprint, tells_lethal_and_unknown_faces_that_it_touches)
{
  Ground ground;
  ground.costs[51 * 25 + 25] = std::numeric_limits<float>::infinity();  // at (5, 5)
  EXPECT_TRUE(ground.under(square(0.01)).lethal[0]);
  EXPECT_EQ(ground.under(square(0.01)).max_costs[0], 0.0f);
  const std::vector<double> beside = {1, 0, 0, 6, 0, 1, 0, 5, 0, 0, 1, 0};
  EXPECT_FALSE(ground.under(square(0.7), beside).lethal[0]);
  EXPECT_TRUE(ground.under(square(0.801), beside).lethal[0]);
  EXPECT_NEAR(ground.under(square(0.801), beside).max_costs[0], 6.801, 1e-5);
  ground.costs[51 * 25 + 25] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(ground.under(square(0.801), beside).unknown[0]);
  EXPECT_FALSE(ground.under(square(0.801), beside).lethal[0]);
}

TEST(Footprint, tells_how_much_of_it_has_ground)
{
  const Ground ground;
  const std::vector<double> poses = {1, 0, 0, 10, 0, 1, 0, 5,  0, 0, 1, 0,    // half over the edge
                                     1, 0, 0, 12, 0, 1, 0, 5,  0, 0, 1, 0,    // beyond it
                                     1, 0, 0, 5,  0, 1, 0, 5,  0, 0, 1, 2.5,  // above the band
                                     1, 0, 0, 10, 0, 1, 0, 10, 0, 0, 1, 0};   // at a corner
  const FootprintCosts found = ground.under(square(0.5), poses);
  EXPECT_EQ(found.ground, (std::vector<double>{0.5, 0.0, 0.0, 0.25}));
  EXPECT_EQ(found.face_counts[1], 0u);
  EXPECT_EQ(found.face_counts[2], 0u);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const FootprintCosts nowhere = ground.under(square(0.5), {1, 0, 0, nan, 0, 1, 0, 5, 0, 0, 1, 0});
  EXPECT_EQ(nowhere.face_counts[0], 0u);
}

TEST(Footprint, refuses_what_is_not_convex)
{
  const Ground ground;
  Footprint clockwise = square(0.5);
  std::swap(clockwise.corners[0], clockwise.corners[2]);
  Footprint dented = square(0.5);
  dented.corners.push_back({0.0, 0.0});
  Footprint twice = square(0.5);
  for (int i = 0; i < 4; ++i) {
    twice.corners.push_back(twice.corners[i]);
  }
  Footprint thin = square(0.5);
  thin.corners.resize(2);
  Footprint inverted = square(0.5);
  inverted.lowest = 3.0;
  for (const Footprint& wrong : {clockwise, dented, twice, thin, inverted}) {
    EXPECT_THROW(ground.under(wrong), std::invalid_argument);
  }
  EXPECT_THROW(ground.under(square(0.5), {1, 2, 3}), std::invalid_argument);
}

}  // namespace
