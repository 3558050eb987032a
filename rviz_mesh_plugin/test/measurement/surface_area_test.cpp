#include "measurement/surface_area.h"

#include <cmath>
#include <random>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "measured_meshes.h"
#include "threads/cancellation.h"

using namespace measured_meshes;
using rviz_mesh_plugin::findArea;
using rviz_mesh_plugin::SurfaceArea;

namespace {

using Plan = std::vector<std::array<double, 2>>;

std::vector<SurfacePoint> on(const MeshData& mesh, const Plan& plan, double z = 0.0)
{
  std::vector<SurfacePoint> points;
  for (const auto& corner : plan) {
    points.push_back(pointAt(mesh, corner[0], corner[1], z));
  }
  return points;
}

double shoelace(const Plan& plan)
{
  double sum = 0.0;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const auto& a = plan[i];
    const auto& b = plan[(i + 1) % plan.size()];
    sum += 0.5 * (a[0] * b[1] - a[1] * b[0]);
  }
  return std::abs(sum);
}

const Plan ARROW{{-0.71, -0.63}, {0.82, -0.05}, {-0.64, 0.77}, {-0.2, 0.03}};

std::string refusal(const MeshData& mesh, const std::vector<SurfacePoint>& corners)
{
  try {
    findArea(mesh, corners);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(SurfaceArea, a_polygon_on_a_slope)
{
  const MeshData mesh = terrain(13, [](double x, double y) { return 0.75 * x - 0.4 * y; });
  const double steeper = std::sqrt(1.0 + 0.75 * 0.75 + 0.4 * 0.4);
  for (const bool backwards : {false, true}) {
    Plan plan = ARROW;
    if (backwards) {
      std::reverse(plan.begin(), plan.end());
    }
    const SurfaceArea area = findArea(mesh, on(mesh, plan));
    EXPECT_NEAR(area.plan, shoelace(ARROW), 1e-12);
    EXPECT_NEAR(area.surface, steeper * shoelace(ARROW), 1e-6);
    EXPECT_EQ(area.walls, 0.0);
    EXPECT_NEAR(area.uncovered, 0.0, 1e-6);
    EXPECT_TRUE(area.connected);
    EXPECT_FALSE(area.steep);
  }
}

TEST(SurfaceArea, the_sides_of_the_outline_along_edges)
{
  const MeshData mesh = terrain(8, [](double, double) { return 0.0; });
  const Plan plan{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {0.0, 0.0}, {-0.5, 0.5}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan));
  EXPECT_NEAR(area.surface, 0.75, 1e-9);
  EXPECT_NEAR(area.uncovered, 0.0, 1e-9);
  EXPECT_NEAR(area.outline, 3.0 + 2.0 * std::sqrt(0.5), 1e-9);
}

TEST(SurfaceArea, outlines_of_any_shape_are_those_of_many_samples)
{
  std::mt19937 random(7);
  const auto height = [](double x, double y) { return 0.3 * std::sin(4 * x) * std::cos(3 * y); };
  const MeshData mesh = terrain(20, height);
  for (int i = 0; i < 5; ++i) {
    Plan star;
    for (int corner = 0; corner < 9; ++corner) {
      const double radius = std::uniform_real_distribution<>(0.2, 0.95)(random);
      const double angle = 2 * M_PI * corner / 9;
      star.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    // Each face cut into 100 small ones, counted by their middles.
    double expected = 0.0;
    constexpr int N = 10;
    const auto inside = [&](double x, double y) {
      bool in = false;
      for (std::size_t j = 0; j < star.size(); ++j) {
        const auto& a = star[j];
        const auto& b = star[(j + 1) % star.size()];
        in ^= (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
      }
      return in;
    };
    for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
      const auto a = rviz_mesh_plugin::vectorOf(rviz_mesh_plugin::cornerOf(mesh, face, 0));
      const auto b = rviz_mesh_plugin::vectorOf(rviz_mesh_plugin::cornerOf(mesh, face, 1));
      const auto c = rviz_mesh_plugin::vectorOf(rviz_mesh_plugin::cornerOf(mesh, face, 2));
      const double small = 0.5 * rviz_mesh_plugin::normalOf(mesh, face).norm() / (N * N);
      for (int u = 0; u < N; ++u) {
        for (int v = 0; v < N - u; ++v) {
          for (const double third : {1.0 / 3.0, 2.0 / 3.0}) {
            if (third > 0.5 && v == N - u - 1) {
              continue;
            }
            const auto at = a + (u + third) / N * (b - a) + (v + third) / N * (c - a);
            expected += inside(at[0], at[1]) ? small : 0.0;
          }
        }
      }
    }
    const SurfaceArea area = findArea(mesh, on(mesh, star));
    EXPECT_NEAR(area.surface, expected, 0.005 * expected);
    EXPECT_NEAR(area.uncovered, 0.0, 1e-6);
  }
}

TEST(SurfaceArea, walls_count_apart_and_the_top_of_a_block_with_the_floor)
{
  // A floor from -2 to 2 with a block of 1 m by 1 m, 0.5 m high, that belongs to it.
  MeshData mesh;
  const std::array<float, 4> ticks{-2, 0, 1, 2};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const float z = i == 1 && j == 1 ? 0.5f : 0.0f;
      addQuad(mesh, {{{ticks[i], ticks[j], z},
                      {ticks[i + 1], ticks[j], z},
                      {ticks[i + 1], ticks[j + 1], z},
                      {ticks[i], ticks[j + 1], z}}});
    }
  }
  addQuad(mesh, {{{0, 1, 0}, {0, 0, 0}, {0, 0, 0.5f}, {0, 1, 0.5f}}});
  addQuad(mesh, {{{1, 0, 0}, {1, 1, 0}, {1, 1, 0.5f}, {1, 0, 0.5f}}});
  const Plan plan{{-1.5, -1.25}, {1.5, -1.25}, {1.5, 1.25}, {-1.5, 1.25}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan));
  EXPECT_NEAR(area.plan, 7.5, 1e-12);
  EXPECT_NEAR(area.surface, 7.5, 1e-6);
  EXPECT_NEAR(area.walls, 1.0, 1e-6) << "those at x = 0 and x = 1";
  EXPECT_NEAR(area.uncovered, 0.0, 1e-6);
}

TEST(SurfaceArea, a_wall_where_the_outline_is_taken_apart_counts_once)
{
  MeshData mesh = terrain(8, [](double, double) { return 0.0; });
  for (const float at : {-0.25f, 0.0f, 0.25f}) {
    addQuad(mesh,
            {{{at, at, 0}, {at + 0.25f, at + 0.25f, 0}, {at + 0.25f, at + 0.25f, 1}, {at, at, 1}}});
  }
  const Plan plan{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan));
  EXPECT_NEAR(area.walls, 0.75 * std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(area.surface, 1.0, 1e-6);
}

TEST(SurfaceArea, what_is_connected_outside_of_the_outline_does_not_count)
{
  // A comb: three teeth below a back, of squares of 1 m.
  MeshData mesh;
  for (float x = 0; x < 5; ++x) {
    addQuad(mesh, {{{x, 1, 0}, {x + 1, 1, 0}, {x + 1, 2, 0}, {x, 2, 0}}});
    if (x != 1 && x != 3) {
      addQuad(mesh, {{{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}}});
    }
  }
  const Plan plan{{0.2, 0.2}, {4.8, 0.2}, {4.8, 1.8}, {4.6, 1.8}, {4.6, 0.8}, {0.2, 0.8}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan));
  EXPECT_NEAR(area.surface, 0.8 * 0.6 + 0.8 * 0.6 + 0.2, 1e-6) << "not the tooth in the middle";
  EXPECT_NEAR(area.uncovered, 3 * 0.6, 1e-6);
  EXPECT_FALSE(area.connected);
}

TEST(SurfaceArea, what_is_above_and_below_does_not_count)
{
  // A room with a pillar of 2/3 m by 2/3 m, by which the ceiling belongs to the floor.
  const std::vector<std::uint32_t> pillar{28, 29, 30, 31, 40, 41, 42, 43};
  MeshData mesh = without(terrain(6, [](double, double) { return 0.0; }), pillar);
  MeshData ceiling = without(terrain(6, [](double, double) { return 2.0; }), pillar);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), ceiling.vertices.begin(), ceiling.vertices.end());
  for (std::size_t i = 0; i < ceiling.indices.size(); i += 3) {
    for (const std::size_t corner : {0, 2, 1}) {
      mesh.indices.push_back(first + ceiling.indices[i + corner]);
    }
  }
  const std::size_t corners[] = {16, 17, 18, 25, 32, 31, 30, 23, 16};  // of the pillar
  for (std::size_t i = 0; i + 1 < std::size(corners); ++i) {
    const auto a = mesh.vertices[corners[i]].position, b = mesh.vertices[corners[i + 1]].position;
    addQuad(mesh, {{b, a, {a[0], a[1], 2}, {b[0], b[1], 2}}});
  }
  const Plan plan{{-0.9, -0.9}, {0.95, -0.9}, {0.95, 0.9}, {-0.9, 0.9}};
  for (const double z : {0.0, 2.0}) {
    const SurfaceArea area = findArea(mesh, on(mesh, plan, z));
    EXPECT_NEAR(area.surface, shoelace(plan) - 4.0 / 9.0, 1e-6) << z;
    EXPECT_NEAR(area.walls, 4 * 2.0 / 3.0 * 2.0, 1e-5) << z;
    EXPECT_NEAR(area.uncovered, 4.0 / 9.0, 1e-6) << z;
  }
}

TEST(SurfaceArea, holes_are_told)
{
  const MeshData mesh = without(terrain(10, [](double, double) { return 1.0; }),
                                {88, 89, 90, 91});  // 0.4 m by 0.2 m, x -0.2 to 0.2, y -0.2 to 0
  const Plan plan{{-0.7, -0.7}, {0.7, -0.7}, {0.7, 0.7}, {-0.7, 0.7}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan, 1.0));
  EXPECT_NEAR(area.surface, 1.96 - 0.08, 1e-6);
  EXPECT_NEAR(area.uncovered, 0.08, 1e-6);
}

TEST(SurfaceArea, corners_on_surfaces_that_are_not_connected)
{
  MeshData mesh = terrain(4, [](double, double) { return 0.0; });
  addQuad(mesh, {{{1.5f, -1, 0}, {3, -1, 0}, {3, 1, 0}, {1.5f, 1, 0}}});
  const Plan plan{{0.5, -0.5}, {2.0, -0.5}, {2.0, 0.5}, {0.5, 0.5}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan));
  EXPECT_FALSE(area.connected);
  EXPECT_NEAR(area.surface, 1.0, 1e-6);
  EXPECT_NEAR(area.uncovered, 0.5, 1e-6);
}

TEST(SurfaceArea, a_corner_on_a_wall_that_stands_unconnected_on_the_floor)
{
  for (const bool connected : {true, false}) {
    MeshData mesh = terrain(4, [](double, double) { return 0.0; });
    const float aside = connected ? 0.0f : 0.1f;
    const auto wall = static_cast<std::uint32_t>(mesh.faceCount() + 5);  // in its upper half
    for (const auto& [low, high] : {std::pair{0.0f, 1.0f}, {1.0f, 2.0f}}) {
      for (const float y : {0.0f, 0.5f}) {
        addQuad(mesh, {{{0.5f, y - aside, low},
                        {0.5f, y + 0.5f - aside, low},
                        {0.5f, y + 0.5f - aside, high},
                        {0.5f, y - aside, high}}});
      }
    }
    for (const double rounded : {-1e-7, 0.0, 1e-7}) {
      std::vector<SurfacePoint> corners = on(mesh, {{-0.7, -0.7}, {0.3, -0.7}, {-0.7, 0.2}});
      corners.insert(corners.begin() + 2, {wall, {0.5 + rounded, 0.2, 1.7}});
      const SurfaceArea area = findArea(mesh, corners);
      EXPECT_EQ(area.connected, connected) << rounded;
      EXPECT_NEAR(area.surface, area.plan, 1e-6);
    }
  }
}

TEST(SurfaceArea, on_a_wall)
{
  MeshData mesh;
  // 4 m by 3 m, turned by 30 degrees.
  const float c = std::cos(float(M_PI) / 6), s = std::sin(float(M_PI) / 6);
  addQuad(mesh, {{{0, 0, 0}, {4 * c, 4 * s, 0}, {4 * c, 4 * s, 3}, {0, 0, 3}}});
  const auto at = [&](double along, double z) {
    const bool lower = z / 3 < along / 4;
    return SurfacePoint{lower ? 0u : 1u, {along * double{c}, along * double{s}, z}};
  };
  const SurfaceArea area = findArea(mesh, {at(0.5, 0.5), at(3.0, 0.5), at(3.0, 2.5), at(0.5, 2.5)});
  EXPECT_TRUE(area.steep);
  EXPECT_NEAR(area.surface, 5.0, 1e-5);
  EXPECT_NEAR(area.plan, 0.0, 1e-9);
  EXPECT_NEAR(area.uncovered, 0.0, 1e-5);
}

TEST(SurfaceArea, a_face_that_is_turned_round_counts)
{
  const MeshData mesh = world("flipped_face");  // 3 m by 3 m, level
  const Plan plan{{0.1, 0.1}, {2.9, 0.1}, {2.9, 2.9}, {0.1, 2.9}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan));
  EXPECT_NEAR(area.surface, 2.8 * 2.8, 1e-5);
}

namespace {

/// A storey of slabs of 20 m by 6 m and 0.3 m, the upper one of two parts, on walls at the joint
/// and at the end.
MeshData storey()
{
  MeshData mesh;
  addBox(mesh, {0, 0, 0}, {10, 6, 0.3f});
  addBox(mesh, {10, 0, 0}, {20, 6, 0.3f});
  addBox(mesh, {9.8f, 0, -3}, {10, 6, 0});
  addBox(mesh, {0, 0, -3.3f}, {20, 6, -3});
  addBox(mesh, {0, 0, -3}, {0.2f, 6, 0});
  return mesh;
}

}  // namespace

TEST(SurfaceArea, parts_that_share_an_edge_lead_neither_inside_nor_below)
{
  const MeshData mesh = storey();
  const Plan plan{{6, 1}, {14, 1}, {14, 5}, {6, 5}};
  const SurfaceArea roof = findArea(mesh, on(mesh, plan, 0.3));
  EXPECT_NEAR(roof.surface, 32.0, 1e-5);
  EXPECT_EQ(roof.walls, 0.0);
  EXPECT_NEAR(roof.uncovered, 0.0, 1e-5);
  EXPECT_EQ(roof.doubled, 0.0);
  EXPECT_TRUE(roof.connected) << "over the joint";
  // From below: with the foot of the wall, which only touches the floor.
  const SurfaceArea ceiling = findArea(mesh, on(mesh, plan, 0.0));
  EXPECT_NEAR(ceiling.surface, 32.0 + 4 * 0.2, 1e-5);
  EXPECT_NEAR(ceiling.doubled, 4 * 0.2, 1e-5);
  EXPECT_NEAR(ceiling.walls, 2 * 4.0 * 3.0, 1e-5);
}

TEST(SurfaceArea, an_outer_wall_with_the_edges_of_its_slabs)
{
  const MeshData mesh = storey();
  const std::uint32_t wall = 4 * 12 + 10, floor = 3 * 12 + 10, slab = 10;  // at x = 0
  for (const bool backwards : {false, true}) {
    std::vector<SurfacePoint> corners{{floor, {0, 1, -3.2}},
                                      {floor, {0, 5, -3.2}},
                                      {slab, {0, 5, 0.2}},
                                      {wall, {0, 3, -0.1}},
                                      {slab, {0, 1, 0.2}}};
    if (backwards) {
      std::reverse(corners.begin(), corners.end());
    }
    const SurfaceArea area = findArea(mesh, corners);
    EXPECT_TRUE(area.steep);
    EXPECT_NEAR(area.surface, 4 * 3.4 - 0.5 * 4 * 0.3, 1e-5);
    EXPECT_EQ(area.walls, 0.0);
    EXPECT_TRUE(area.connected);
  }
}

TEST(SurfaceArea, a_roof_and_a_ramp)
{
  MeshData mesh = storey();
  addQuad(mesh, {{{20, 0, 0.3f}, {30, 0, -3}, {30, 6, -3}, {20, 6, 0.3f}}});  // a sheet on a solid
  const Plan plan{{15, 2}, {25, 2}, {25, 4}, {15, 4}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan, 0.3));
  EXPECT_NEAR(area.surface, 2 * (5 + std::hypot(5.0, 0.5 * 3.3)), 1e-5);
  EXPECT_EQ(area.walls, 0.0) << "below the ramp";
  EXPECT_TRUE(area.connected);
}

TEST(SurfaceArea, walls_of_sheets_stand_on_a_floor_that_goes_on_behind_them)
{
  for (const bool below : {false, true}) {
    MeshData mesh;
    for (float x = 0; x < 3; ++x) {
      addQuad(mesh, {{{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}}});
    }
    for (float x = 1; x < 3; ++x) {
      addQuad(mesh, {{{x, 0, 0}, {x, 1, 0}, {x, 1, 2}, {x, 0, 2}}});
      if (below) {  // as of the storey there
        addQuad(mesh, {{{x, 0, -2}, {x, 1, -2}, {x, 1, 0}, {x, 0, 0}}});
      }
    }
    const Plan plan{{0.25, 0.25}, {2.75, 0.25}, {2.75, 0.75}, {0.25, 0.75}};
    const SurfaceArea area = findArea(mesh, on(mesh, plan));
    EXPECT_NEAR(area.surface, 2.5 * 0.5, 1e-6) << below;
    EXPECT_NEAR(area.walls, 2 * 0.5 * 2, 1e-6) << below;
    EXPECT_TRUE(area.connected) << below;
  }
}

TEST(SurfaceArea, faces_in_the_same_places_count_once)
{
  const MeshData plate =
      without(terrain(10, [](double, double) { return 0.0; }), {88, 89, 90, 91});  // 0.4 m by 0.2 m
  MeshData mesh = plate;
  for (int copy = 0; copy < 2; ++copy) {
    for (std::size_t i = 0; i < plate.indices.size(); i += 3) {
      for (const std::size_t corner : {1, copy == 0 ? 2 : 0, copy == 0 ? 0 : 2}) {
        mesh.indices.push_back(plate.indices[i + corner]);
      }
    }
    const Plan plan{{-0.7, -0.7}, {0.7, -0.7}, {0.7, 0.7}, {-0.7, 0.7}};
    std::vector<SurfacePoint> corners = on(mesh, plan);
    for (const bool last : {false, true}) {
      corners[2].face +=
          last ? static_cast<std::uint32_t>(mesh.faceCount() - plate.faceCount()) : 0;
      const SurfaceArea area = findArea(mesh, corners);
      EXPECT_NEAR(area.surface, 1.96 - 0.08, 1e-6) << copy;
      EXPECT_NEAR(area.uncovered, 0.08, 1e-6) << copy;
      EXPECT_TRUE(area.connected) << copy;
    }
  }
}

TEST(SurfaceArea, thin_faces_that_rounding_has_turned_over_do_not_stop_it)
{
  // Between coarse floors a finer one, with a face at each side whose third corner is in the edge.
  const float one = std::nextafter(1.0f, 0.0f), two = std::nextafter(2.0f, 3.0f);
  MeshData mesh;
  addQuad(mesh, {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
  addQuad(mesh, {{{2, 0, 0}, {3, 0, 0}, {3, 1, 0}, {2, 1, 0}}});
  const std::array<std::array<float, 3>, 6> places{
      {{1, 0, 0}, {one, 0.5f, 0}, {1, 1, 0}, {2, 1, 0}, {two, 0.5f, 0}, {2, 0, 0}}};
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const auto& place : places) {
    mesh.vertices.push_back({place, {}});
  }
  for (const std::uint32_t corner : {0, 1, 2, 5, 3, 4, 0, 5, 1, 5, 4, 1, 4, 3, 1, 3, 2, 1}) {
    mesh.indices.push_back(first + corner);
  }
  const Plan plan{{0.5, 0.25}, {2.5, 0.25}, {2.5, 0.75}, {0.5, 0.75}};
  const SurfaceArea area = findArea(mesh, on(mesh, plan));
  EXPECT_NEAR(area.surface, 1.0, 1e-6);
  EXPECT_EQ(area.walls, 0.0);
  EXPECT_NEAR(area.uncovered, 0.0, 1e-6);
  EXPECT_TRUE(area.connected);
}

TEST(SurfaceArea, of_storeys_of_a_building)
{
  const MeshData mesh = world("building");
  const Plan plan{{24.5, 1.0}, {35.0, 1.0}, {35.0, 13.0}, {24.5, 13.0}};  // with six pillars
  for (const double z : {0.0, 3.2}) {
    const SurfaceArea area = findArea(mesh, on(mesh, plan, z));
    EXPECT_NEAR(area.surface, 10.5 * 12.0 - 6 * 0.25, 1e-4) << z;
    EXPECT_NEAR(area.uncovered, 6 * 0.25, 1e-4);
  }
}

TEST(SurfaceArea, what_is_refused_and_given_up)
{
  const MeshData mesh = terrain(4, [](double, double) { return 0.0; });
  EXPECT_EQ(refusal(mesh, on(mesh, {{0.1, 0.1}, {0.5, 0.5}})),
            "an outline has at least three corners");
  EXPECT_EQ(refusal(mesh, on(mesh, {{-0.5, -0.5}, {0.5, 0.5}, {0.5, -0.5}, {-0.5, 0.5}})),
            "the outline crosses itself, by its sides 1 and 3");
  EXPECT_EQ(refusal(mesh, on(mesh, {{-0.5, -0.5}, {0.0, 0.0}, {0.5, 0.5}})),
            "the outline has no area: its corners lie in a line");
  const std::atomic<bool> cancel{true};
  EXPECT_THROW(findArea(mesh, on(mesh, ARROW), &cancel), rviz_mesh_plugin::Canceled);
}
