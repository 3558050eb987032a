// Vertices under footprints. Also with sanitizers.

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/support/test_meshes.h"
#include "paths/footprint.h"

namespace {

using mesh_map::Bvh;
using mesh_map::Footprint;
using mesh_map::FootprintVertices;
using Vertices = std::vector<std::uint32_t>;

constexpr double NOT_A_NUMBER = std::numeric_limits<double>::quiet_NaN();

Footprint square(double half)
{
  return {{{half, -half}, {half, half}, {-half, half}, {-half, -half}}, -0.5, 0.5};
}

std::vector<double> at(double x, double y, double z = 0.0)
{
  return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z};
}

/// A flat square of 10 m, with a vertex every 0.2 m.
FootprintVertices under(const Footprint& footprint, const std::vector<double>& poses)
{
  TestMesh mesh = terrain(50);
  for (std::size_t i = 2; i < mesh.positions.size(); i += 3) {
    mesh.positions[i] = 0.0f;
  }
  return footprintVertices(Bvh::build(mesh.view()), mesh.view(), footprint, poses);
}

TEST(FootprintVertices, are_those_whose_ground_it_touches)
{
  const std::uint32_t middle = 51 * 25 + 25;  // at (5, 5)
  EXPECT_EQ(under(square(0.01), at(5.0, 5.0)).vertices, (Vertices{middle}));
  EXPECT_EQ(under(square(0.01), at(5.05, 5.03)).vertices, (Vertices{middle}));
  EXPECT_EQ(under(square(0.101), at(5.0, 5.0)).vertices.size(), 9u);
  EXPECT_EQ(under(square(0.301), at(5.0, 5.0)).vertices.size(), 25u);
}

TEST(FootprintVertices, are_listed_for_each_pose)
{
  std::vector<double> poses;
  for (const std::vector<double>& pose :
       {at(5, 5), at(50, 5), at(5, 5, 0.6), at(NOT_A_NUMBER, 5), at(0, 0)}) {
    poses.insert(poses.end(), pose.begin(), pose.end());
  }
  const FootprintVertices found = under(square(0.01), poses);
  EXPECT_EQ(found.offsets, (std::vector<std::uint64_t>{0, 1, 1, 1, 1, 2}));
  EXPECT_EQ(found.vertices, (Vertices{51 * 25 + 25, 0}));
}

TEST(FootprintVertices, of_polygons_of_many_corners)
{
  for (const int corners : {3, 14, 15, 16, 40, 200}) {
    Footprint circle{{}, -0.5, 0.5};
    for (int i = 0; i < corners; ++i) {
      const double angle = 6.283185307179586 * i / corners;
      circle.corners.push_back({std::cos(angle), std::sin(angle)});
    }
    const std::size_t count = under(circle, at(5, 5)).vertices.size();
    const double area = 0.5 * corners * std::sin(6.283185307179586 / corners);
    EXPECT_GT(static_cast<double>(count), area / 0.04) << corners;
    EXPECT_LT(static_cast<double>(count), area / 0.04 + 2 * 3.1416 / 0.2 + 10) << corners;
  }
}

TEST(FootprintVertices, refuses_what_is_no_footprint_or_pose)
{
  Footprint clockwise = square(0.5);
  std::swap(clockwise.corners[0], clockwise.corners[2]);
  EXPECT_THROW(under(clockwise, at(5, 5)), std::invalid_argument);
  EXPECT_THROW(under(square(0.5), {1, 2, 3}), std::invalid_argument);
}

}  // namespace
