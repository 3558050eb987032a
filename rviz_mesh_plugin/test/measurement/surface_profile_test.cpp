#include "measurement/surface_profile.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "measured_meshes.h"
#include "threads/cancellation.h"

using namespace measured_meshes;
using rviz_mesh_plugin::findProfile;
using rviz_mesh_plugin::SurfaceProfile;

namespace {

void expectPoints(const SurfaceProfile::Piece& piece,
                  const std::vector<std::pair<double, double>>& expected, double near = 1e-6)
{
  ASSERT_EQ(piece.size(), expected.size());
  for (std::size_t i = 0; i < piece.size(); ++i) {
    EXPECT_NEAR(piece[i].distance, expected[i].first, near) << i;
    EXPECT_NEAR(piece[i].z, expected[i].second, near) << i;
  }
}

/// Every point of it is on the mesh, and between two points it is straight there, too.
void expectOnMesh(const MeshData& mesh, const SurfaceProfile& profile)
{
  for (const auto& piece : profile.pieces) {
    for (std::size_t i = 1; i < piece.size(); ++i) {
      for (const double share : {0.0, 0.37, 1.0}) {
        const SurfaceProfile::Point p{
            piece[i - 1].distance + share * (piece[i].distance - piece[i - 1].distance),
            piece[i - 1].z + share * (piece[i].z - piece[i - 1].z)};
        const auto at = profile.position(p);
        double least = 1e9;
        for (const auto& [height, face] : heightsAt(mesh, at[0], at[1])) {
          least = std::min(least, std::abs(height - p.z));
        }
        if (std::abs(piece[i].distance - piece[i - 1].distance) > 1e-6) {
          EXPECT_LT(least, 1e-5) << p.distance << " " << p.z;
        }
      }
    }
  }
}

/// A strip along x, 2 m wide, over these points (x, z).
MeshData strip(const std::vector<std::pair<float, float>>& points)
{
  MeshData mesh;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto [x0, z0] = points[i - 1];
    const auto [x1, z1] = points[i];
    addQuad(mesh, {{{x0, -1, z0}, {x1, -1, z1}, {x1, 1, z1}, {x0, 1, z0}}});
  }
  return mesh;
}

void append(MeshData& mesh, const MeshData& other)
{
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const std::uint32_t vertex : other.indices) {
    mesh.indices.push_back(first + vertex);
  }
}

/// As modelers write sheets that are seen from both sides: each face again, turned round.
MeshData doubled(MeshData mesh)
{
  const std::vector<std::uint32_t> faces = mesh.indices;
  for (std::size_t i = 0; i < faces.size(); i += 3) {
    mesh.indices.insert(mesh.indices.end(), {faces[i], faces[i + 2], faces[i + 1]});
  }
  return mesh;
}

}  // namespace

TEST(SurfaceProfile, a_slope_rises_as_it_does)
{
  const MeshData mesh = terrain(10, [](double x, double y) { return 0.5 * x + 0.25 * y; });
  const auto profile = findProfile(mesh, pointAt(mesh, -0.7, -0.3), pointAt(mesh, 0.8, 0.55));
  EXPECT_TRUE(profile.connected);
  EXPECT_TRUE(profile.gaps().empty());
  EXPECT_NEAR(profile.length, std::hypot(1.5, 0.85), 1e-12);
  ASSERT_EQ(profile.pieces.size(), 1u);
  EXPECT_GE(profile.pieces[0].size(), 15u) << "a point at each edge";
  for (const auto& point : profile.pieces[0]) {
    const auto at = profile.position(point);
    EXPECT_NEAR(point.z, 0.5 * at[0] + 0.25 * at[1], 1e-6);
  }
  EXPECT_EQ(profile.pieces[0].front().distance, 0.0);
  EXPECT_NEAR(profile.pieces[0].back().distance, profile.length, 1e-9);
  const auto heights = profile.heights();
  const double rise = 0.5 * 1.5 + 0.25 * 0.85;
  EXPECT_NEAR(heights.ascent, rise, 1e-6);
  EXPECT_NEAR(heights.descent, 0.0, 1e-6);
  EXPECT_NEAR(heights.surface, std::hypot(profile.length, rise), 1e-6);
}

TEST(SurfaceProfile, steps_have_their_risers)
{
  // Vertices of each face of its own: seams do not cut it.
  const MeshData mesh = strip({{0, 0}, {1, 0}, {1, 0.5f}, {2, 0.5f}, {2, 0.25f}, {3, 0.25f}});
  const auto profile =
      findProfile(mesh, pointAt(mesh, 0.25, 0.25), pointAt(mesh, 2.75, 0.25, 0.25));
  ASSERT_TRUE(profile.connected);
  const auto heights = profile.heights();
  EXPECT_NEAR(heights.ascent, 0.5, 1e-6);
  EXPECT_NEAR(heights.descent, 0.25, 1e-6);
  EXPECT_NEAR(heights.surface, 2.5 + 0.75, 1e-6);
  EXPECT_NEAR(heights.lowest, 0.0, 1e-6);
  EXPECT_NEAR(heights.highest, 0.5, 1e-6);
  // Diagonals of the quadrilaterals are crossed, too: all points lie on the steps.
  for (const auto& point : profile.pieces[0]) {
    const double s = point.distance + 0.25;
    const bool level = std::abs(point.z - (s < 1 ? 0.0 : s < 2 ? 0.5 : 0.25)) < 1e-6;
    const bool riser = std::abs(s - 1) < 1e-6 || std::abs(s - 2) < 1e-6;
    EXPECT_TRUE(level || riser) << s << " " << point.z;
  }
}

TEST(SurfaceProfile, a_line_through_vertices_and_along_edges_is_the_same)
{
  const MeshData mesh = terrain(4, [](double x, double) { return std::abs(x); });
  const auto along = findProfile(mesh, pointAt(mesh, -0.75, 0.0), pointAt(mesh, 0.5, 0.0));
  ASSERT_TRUE(along.connected);
  ASSERT_EQ(along.pieces.size(), 1u);
  expectPoints(along.pieces[0], {{0, 0.75}, {0.25, 0.5}, {0.75, 0}, {1.25, 0.5}});
  const auto diagonal = findProfile(mesh, pointAt(mesh, -0.5, -0.5), pointAt(mesh, 0.5, 0.5));
  ASSERT_TRUE(diagonal.connected);
  EXPECT_NEAR(diagonal.heights().ascent, 0.5, 1e-6);
  EXPECT_NEAR(diagonal.heights().descent, 0.5, 1e-6);
}

TEST(SurfaceProfile, an_overhang_belongs_to_it)
{
  const MeshData mesh = strip({{0, 0}, {2, 0}, {1.5f, 1}, {3, 1}});
  const auto profile = findProfile(mesh, pointAt(mesh, 0.5, 0.3), pointAt(mesh, 2.75, 0.3, 1.0));
  ASSERT_TRUE(profile.connected);
  EXPECT_NEAR(profile.heights().surface, 1.5 + std::hypot(0.5, 1.0) + 1.25, 1e-6);
}

TEST(SurfaceProfile, a_surface_that_ends_is_followed_as_far_as_it_leads)
{
  MeshData mesh = strip({{0, 0}, {2, 0}, {1.5f, 1}, {3, 1}});
  addQuad(mesh, {{{4, -1, 1}, {5, -1, 1}, {5, 1, 1}, {4, 1, 1}}});
  const auto profile = findProfile(mesh, pointAt(mesh, 0.5, 0.3), pointAt(mesh, 4.5, 0.3, 1.0));
  EXPECT_FALSE(profile.connected);
  ASSERT_EQ(profile.gaps().size(), 1u);
  EXPECT_NEAR(profile.gaps()[0].begin, 2.5, 1e-6);
  EXPECT_NEAR(profile.gaps()[0].end, 3.5, 1e-6);
  EXPECT_NEAR(profile.heights().ascent, 1.0, 1e-6);
}

TEST(SurfaceProfile, gaps_are_told_and_what_lies_between_them_is_kept)
{
  // Squares of 0.2 m: without those at x from -0.4 to -0.2 and 0.2 to 0.6 in the rows of the line.
  const auto ramp = [](double x, double) { return 0.1 * x; };
  std::vector<std::uint32_t> holes;
  for (const std::uint32_t row : {4u, 5u}) {
    for (const std::uint32_t column : {3u, 6u, 7u}) {
      holes.push_back(2 * (10 * row + column));
      holes.push_back(2 * (10 * row + column) + 1);
    }
  }
  MeshData mesh = without(terrain(10, ramp), holes);
  const auto profile = findProfile(mesh, pointAt(mesh, -0.9, 0.05), pointAt(mesh, 0.9, 0.05));
  EXPECT_FALSE(profile.connected);
  ASSERT_EQ(profile.pieces.size(), 3u);
  const auto gaps = profile.gaps();
  ASSERT_EQ(gaps.size(), 2u);
  EXPECT_NEAR(gaps[0].begin, 0.5, 1e-6);
  EXPECT_NEAR(gaps[0].end, 0.7, 1e-6);
  EXPECT_NEAR(gaps[1].begin, 1.1, 1e-6);
  EXPECT_NEAR(gaps[1].end, 1.5, 1e-6);
  expectOnMesh(mesh, profile);
  // What floats in a gap, and belongs to nothing there, is not the surface.
  addQuad(mesh, {{{-0.37f, -1, 0}, {-0.23f, -1, 0}, {-0.23f, 1, 0}, {-0.37f, 1, 0}}});
  EXPECT_EQ(findProfile(mesh, pointAt(mesh, -0.9, 0.05), pointAt(mesh, 0.9, 0.05)).gaps().size(),
            2u);
}

TEST(SurfaceProfile, what_lies_in_a_gap_looks_to_the_same_side)
{
  std::vector<std::uint32_t> holes;
  for (const std::uint32_t row : {4u, 5u}) {
    for (const std::uint32_t column : {4u, 5u}) {
      holes.push_back(2 * (10 * row + column));
      holes.push_back(2 * (10 * row + column) + 1);
    }
  }
  const MeshData floor = without(terrain(10, [](double, double) { return 0.0; }), holes);
  const std::array<std::array<float, 3>, 4> step{
      {{-0.1f, -1, -0.3f}, {0.1f, -1, -0.3f}, {0.1f, 1, -0.3f}, {-0.1f, 1, -0.3f}}};
  for (const bool up : {true, false}) {
    MeshData mesh = floor;
    addQuad(mesh, up ? step : decltype(step){step[3], step[2], step[1], step[0]});
    // It belongs to the floor, by a face at its end.
    const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back({step[3], {}});
    mesh.vertices.push_back({step[2], {}});
    mesh.indices.insert(mesh.indices.end(), {count, count + 1, 120});
    const auto profile = findProfile(mesh, pointAt(mesh, -0.9, 0.05), pointAt(mesh, 0.9, 0.05));
    EXPECT_EQ(profile.gaps().size(), up ? 2u : 1u);
    EXPECT_NEAR(profile.heights().lowest, up ? -0.3 : 0.0, 1e-6);
  }
}

namespace {

/// A floor from x = 0 to 10 with two holes from 2 to 3 and 4 to 5 in the way of a line along
/// y = 0.3, and what lies between these; beside the line it is one surface.
MeshData floorWithHoles(float step)
{
  MeshData mesh;
  for (const auto& [a, b] : std::vector<std::pair<float, float>>{
           {0, 2}, {2, 3}, {3, 3.5f}, {3.5f, 4}, {4, 5}, {5, 10}}) {
    addQuad(mesh, {{{a, 1, 0}, {b, 1, 0}, {b, 2, 0}, {a, 2, 0}}});
    if (a != 2 && a != 4) {
      const float z = a == 3.5f ? step : 0;
      addQuad(mesh, {{{a, -1, z}, {b, -1, z}, {b, 1, z}, {a, 1, z}}});
    }
  }
  return mesh;
}

void expectGaps(const SurfaceProfile& profile, const std::vector<std::pair<double, double>>& gaps)
{
  ASSERT_EQ(profile.gaps().size(), gaps.size());
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    EXPECT_NEAR(profile.gaps()[i].begin, gaps[i].first, 1e-5) << i;
    EXPECT_NEAR(profile.gaps()[i].end, gaps[i].second, 1e-5) << i;
  }
}

}  // namespace

TEST(SurfaceProfile, what_lies_between_gaps_does_not_depend_on_the_faces_of_the_points)
{
  for (const std::string points : {"floor", "turned", "wall", "walls"}) {
    SCOPED_TRACE(points);
    MeshData mesh = floorWithHoles(0);
    SurfacePoint begin = pointAt(mesh, 0.5, 0.3), end = pointAt(mesh, 9.5, 0.3);
    if (points == "turned") {
      std::swap(mesh.indices[3 * end.face], mesh.indices[3 * end.face + 1]);
    } else if (points == "wall") {
      end = {static_cast<std::uint32_t>(mesh.faceCount()), {10.0, 0.3, 1.5}};
      addQuad(mesh, {{{10, -1, 0}, {10, -1, 2}, {10, 1, 2}, {10, 1, 0}}});
    } else if (points == "walls") {  // that only touch the floor
      begin = {static_cast<std::uint32_t>(mesh.faceCount()), {0.5, 0.3, 1.5}};
      addQuad(mesh, {{{0.5f, 0, 0}, {0.5f, 0, 2}, {0.5f, 1, 2}, {0.5f, 1, 0}}});
      end = {static_cast<std::uint32_t>(mesh.faceCount()), {9.5, 0.3, 1.5}};
      addQuad(mesh, {{{9.5f, 0, 0}, {9.5f, 0, 2}, {9.5f, 1, 2}, {9.5f, 1, 0}}});
    }
    const double length = end.position[0] - 0.5;
    expectGaps(findProfile(mesh, begin, end), {{1.5, 2.5}, {3.5, 4.5}});
    expectGaps(findProfile(mesh, end, begin),
               {{length - 4.5, length - 3.5}, {length - 2.5, length - 1.5}});
  }
}

TEST(SurfaceProfile, what_lies_between_gaps_has_its_risers)
{
  for (const std::string riser : {"whole", "other edges", "leaning"}) {
    SCOPED_TRACE(riser);
    MeshData mesh = floorWithHoles(0.2f);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const std::array<float, 3>& place : std::vector<std::array<float, 3>>{
             {3.5f, -1, 0}, {3.5f, 1, 0}, {3.5f, 1, 0.2f}, {3.5f, -1, 0.2f}}) {
      mesh.vertices.push_back({place, {}});
    }
    mesh.indices.insert(mesh.indices.end(), {first, first + 2, first + 1});
    mesh.indices.insert(mesh.indices.end(), {first, first + 3, first + 2});
    if (riser == "other edges") {  // than those of the step
      mesh.vertices[first + 3].position[1] = -0.7f;
    } else if (riser == "leaning") {  // by the last digits, as where a model has been turned
      for (auto& vertex : mesh.vertices) {
        vertex.position[0] -=
            vertex.position == std::array<float, 3>{3.5f, vertex.position[1], 0.2f} ? 1e-6f : 0;
      }
    }
    const SurfacePoint begin = pointAt(mesh, 0.5, 0.23), end = pointAt(mesh, 9.5, 0.37);
    for (const bool swapped : {false, true}) {
      const auto profile = swapped ? findProfile(mesh, end, begin) : findProfile(mesh, begin, end);
      const double stretch = profile.length / 9.0;
      if (swapped) {
        expectGaps(profile, {{4.5 * stretch, 5.5 * stretch}, {6.5 * stretch, 7.5 * stretch}});
      } else {
        expectGaps(profile, {{1.5 * stretch, 2.5 * stretch}, {3.5 * stretch, 4.5 * stretch}});
      }
      EXPECT_NEAR(swapped ? profile.heights().descent : profile.heights().ascent, 0.2, 1e-5);
      expectOnMesh(mesh, profile);
    }
  }
}

TEST(SurfaceProfile, another_storey_is_not_the_profile)
{
  MeshData mesh = terrain(10, [](double x, double) { return 0.1 * x; });
  addQuad(mesh, {{{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}});
  addQuad(mesh, {{{-1, -1, 2}, {-0.5f, -1, 2}, {-0.5f, 1, 2}, {-1, 1, 2}}});
  const auto below = findProfile(mesh, pointAt(mesh, -0.9, 0.1), pointAt(mesh, 0.9, 0.1));
  EXPECT_TRUE(below.connected);
  EXPECT_NEAR(below.heights().highest, 0.09, 1e-6);
  const auto above = findProfile(mesh, pointAt(mesh, -0.9, 0.1, 1), pointAt(mesh, 0.9, 0.1, 1));
  EXPECT_TRUE(above.connected);
  EXPECT_NEAR(above.heights().lowest, 1.0, 1e-6);
  // From one to the other, which is wholly above it: half of each.
  const auto between = findProfile(mesh, pointAt(mesh, -0.9, 0.1), pointAt(mesh, 0.9, 0.1, 1));
  EXPECT_FALSE(between.connected);
  ASSERT_EQ(between.gaps().size(), 1u);
  EXPECT_NEAR(between.gaps()[0].begin, 0.9, 1e-6);
  EXPECT_NEAR(between.gaps()[0].step, 1.0, 1e-6);
  EXPECT_NEAR(between.heights().lowest, -0.09, 1e-6);
  EXPECT_NEAR(between.heights().highest, 1.0, 1e-6);
  const auto down = findProfile(mesh, pointAt(mesh, -0.9, 0.1, 2), pointAt(mesh, 0.9, 0.1, 1));
  ASSERT_EQ(down.pieces.size(), 2u);
  EXPECT_NEAR(down.pieces[0].back().distance, 0.4, 1e-6);
  EXPECT_NEAR(down.pieces[1].front().distance, 0.4, 1e-6);
  EXPECT_NEAR(down.pieces[1].front().z, 1.0, 1e-6);
}

TEST(SurfaceProfile, a_ramp_between_the_storeys_of_a_building)
{
  const MeshData mesh = world("building");  // the ramp rises by 3.2 m from x = 10 to 22, y = 11.5
  const auto profile =
      findProfile(mesh, pointAt(mesh, 9.0, 11.5, 0.0), pointAt(mesh, 23.0, 11.5, 3.2));
  ASSERT_TRUE(profile.connected) << profile.pieces.size();
  ASSERT_EQ(profile.pieces.size(), 1u);
  for (const auto& point : profile.pieces[0]) {
    const double x = 9.0 + point.distance;
    EXPECT_NEAR(point.z, std::clamp((x - 10.0) / 12.0, 0.0, 1.0) * 3.2, 1e-5) << x;
  }
  // The lower floor below the ramp: it ends where the ramp begins, the line goes up it.
  const auto lower =
      findProfile(mesh, pointAt(mesh, 9.0, 11.5, 0.0), pointAt(mesh, 23.0, 11.5, 0.0));
  EXPECT_FALSE(lower.connected);
  expectOnMesh(mesh, lower);
}

TEST(SurfaceProfile, stairs_that_only_touch_the_floor)
{
  const MeshData mesh = world("stairs");  // 8 steps of 0.3 by 0.17 m from x = 2 on
  const auto profile =
      findProfile(mesh, pointAt(mesh, 0.6, 0.5, 0.0), pointAt(mesh, 4.3, 0.5, 8 * 0.17));
  ASSERT_TRUE(profile.connected);
  EXPECT_NEAR(profile.heights().ascent, 8 * 0.17, 1e-5);
  EXPECT_NEAR(profile.heights().descent, 0.0, 1e-5);
  EXPECT_NEAR(profile.heights().surface, 3.7 + 8 * 0.17, 1e-5);
  for (const auto& point : profile.pieces[0]) {
    const double steps = (0.6 + point.distance - 2.0) / 0.3;
    const double low = steps < -1e-4 ? 0.0 : 0.17 * std::floor(steps + 1.0 - 1e-4);
    const double high = steps < -1e-4 ? 0.0 : 0.17 * std::floor(steps + 1.0 + 1e-4);
    EXPECT_GE(point.z, std::max(0.0, low) - 1e-5) << point.distance;
    EXPECT_LE(point.z, high + 1e-5) << point.distance;
  }
}

TEST(SurfaceProfile, a_box_that_stands_on_a_floor)
{
  for (const float height : {0.0f, 0.01f}) {
    MeshData mesh;
    addBox(mesh, {0, 0, -0.3f}, {10, 6, 0});
    addBox(mesh, {6, 1, height}, {9, 5, 1});
    const SurfacePoint floor = pointAt(mesh, 1.02, 2.96), top = pointAt(mesh, 8.02, 2.96, 1.0);
    for (const bool down : {false, true}) {
      const auto profile = down ? findProfile(mesh, top, floor) : findProfile(mesh, floor, top);
      const auto heights = profile.heights();
      EXPECT_NEAR(heights.lowest, 0.0, 1e-6);
      EXPECT_NEAR(heights.highest, 1.0, 1e-6);
      EXPECT_EQ(profile.connected, height == 0.0f);
      const auto gaps = profile.gaps();
      if (height == 0.0f) {
        EXPECT_NEAR(heights.surface, 8.0, 1e-5);
        EXPECT_TRUE(gaps.empty());
        continue;
      }
      EXPECT_NEAR(heights.surface, 7.0, 1e-5);
      ASSERT_EQ(gaps.size(), 1u);
      EXPECT_NEAR(gaps[0].begin, down ? 2.02 : 4.98, 1e-5);
      EXPECT_NEAR(gaps[0].end, gaps[0].begin, 1e-5);
      EXPECT_NEAR(gaps[0].step, down ? -1.0 : 1.0, 1e-5);
    }
    if (height == 0.0f) {  // not below it
      const auto over = findProfile(mesh, floor, pointAt(mesh, 9.62, 2.96));
      EXPECT_NEAR(over.heights().surface, 8.6 + 2.0, 1e-5);
      EXPECT_NEAR(over.heights().highest, 1.0, 1e-6);
    }
  }
}

TEST(SurfaceProfile, an_overhang_where_it_changes_to_another_surface)
{
  MeshData mesh = strip({{0, 0}, {5.2f, 0}, {5, 1}, {10, 1}});
  addQuad(mesh, {{{0, -1, 5}, {5.1f, -1, 5}, {5.1f, 1, 5}, {0, 1, 5}}});
  const SurfacePoint above = pointAt(mesh, 0.0, 0.3, 5.0), below = pointAt(mesh, 10.0, 0.3, 1.0);
  for (const bool swapped : {false, true}) {
    const auto profile =
        swapped ? findProfile(mesh, below, above) : findProfile(mesh, above, below);
    ASSERT_EQ(profile.pieces.size(), 2u);
    expectOnMesh(mesh, profile);
    EXPECT_NEAR(profile.heights().surface, 10.0, 1e-6);
    EXPECT_NEAR(profile.heights().lowest, 1.0, 1e-6) << "not below where the overhang leads back";
    ASSERT_EQ(profile.gaps().size(), 1u);
    EXPECT_NEAR(profile.gaps()[0].begin, swapped ? 4.9 : 5.1, 1e-6);
    EXPECT_NEAR(profile.gaps()[0].step, swapped ? 4.0 : -4.0, 1e-6);
  }
}

TEST(SurfaceProfile, sheets_of_two_sides_stand_on_a_floor_as_those_of_one_do)
{
  const MeshData floor = strip({{0, 0}, {10, 0}}), ramp = strip({{4, 0}, {7, 1}, {9, 1}});
  for (const bool all : {false, true}) {
    MeshData mesh = all ? doubled(floor) : floor;
    append(mesh, doubled(ramp));
    const SurfacePoint begin = pointAt(mesh, 1.0, 0.3), top = pointAt(mesh, 8.0, 0.3, 1.0);
    for (const bool down : {false, true}) {
      const auto profile = down ? findProfile(mesh, top, begin) : findProfile(mesh, begin, top);
      EXPECT_TRUE(profile.connected) << all;
      EXPECT_NEAR(profile.heights().surface, 4.0 + std::hypot(3.0, 1.0), 1e-5) << all;
    }
  }
}

TEST(SurfaceProfile, the_way_leads_over_boxes_of_sheets_of_two_sides)
{
  MeshData floor, box;
  addBox(floor, {0, 0, -0.3f}, {10, 6, 0});
  addBox(box, {6, 1, 0}, {9, 5, 1});
  for (const auto& [floor_is, box_is] : {std::pair{true, false}, {false, true}, {true, true}}) {
    MeshData mesh = floor_is ? doubled(floor) : floor;
    append(mesh, box_is ? doubled(box) : box);
    // Along the line through the middle of the faces, too.
    for (const double y : {2.96, 3.0}) {
      const auto profile = findProfile(mesh, pointAt(mesh, 1.02, y), pointAt(mesh, 9.62, y));
      EXPECT_TRUE(profile.connected);
      EXPECT_NEAR(profile.heights().surface, 8.6 + 2.0, 1e-5) << floor_is << box_is << y;
    }
  }
}

TEST(SurfaceProfile, what_goes_on_beside_a_sheet_of_two_sides_does_not_lie_on_it)
{
  // A detour of 3 m over a hump, where short parts of the straight way do not count a thousandfold.
  MeshData mesh =
      doubled(strip({{0, 0}, {4, 0}, {4.0006f, 0}, {4.0012f, 0}, {4.0018f, 0}, {8, 0}}));
  append(mesh, doubled(strip({{3, 0}, {4, 0.9f}, {5, 0}})));
  const auto profile = findProfile(mesh, pointAt(mesh, 1.0, 0.3), pointAt(mesh, 7.0, 0.3));
  EXPECT_NEAR(profile.heights().surface, 6.0, 1e-5);
}

TEST(SurfaceProfile, the_way_leads_over_boxes_with_the_same_faces_between_them)
{
  MeshData mesh;
  addBox(mesh, {0, 0, -0.3f}, {10, 6, 0});
  addBox(mesh, {6, 1, 0}, {9, 5, 0.5f});
  MeshData upper;
  addBox(upper, {6, 1, 0.5f}, {9, 5, 1});
  append(mesh, without(upper, {2, 3}));
  addQuad(mesh,
          {{{6, 1, 0.5f}, {6, 5, 0.5f}, {9, 5, 0.5f}, {9, 1, 0.5f}}});  // the top of the lower
  const auto profile = findProfile(mesh, pointAt(mesh, 1.02, 2.96), pointAt(mesh, 9.62, 2.96));
  EXPECT_TRUE(profile.connected);
  EXPECT_NEAR(profile.heights().surface, 8.6 + 2.0, 1e-5);
}

TEST(SurfaceProfile, a_face_without_area_at_an_end)
{
  const MeshData floor = strip({{0, 0}, {10, 0}}), ramp = strip({{4, 0}, {7, 1}, {9, 1}});
  for (const bool first : {false, true}) {
    MeshData mesh;
    MeshData edge;  // along the foot of the ramp
    edge.vertices = {ramp.vertices[0], ramp.vertices[3]};
    edge.indices = {0, 0, 1};
    append(mesh, floor);
    append(mesh, first ? edge : ramp);
    append(mesh, first ? ramp : edge);
    const auto profile = findProfile(mesh, pointAt(mesh, 1.0, 0.3), pointAt(mesh, 8.0, 0.3, 1.0));
    EXPECT_TRUE(profile.connected) << first;
    EXPECT_NEAR(profile.heights().surface, 4.0 + std::hypot(3.0, 1.0), 1e-5) << first;
  }
}

TEST(SurfaceProfile, a_box_with_chamfers_stands_on_a_floor)
{
  for (const float size : {1e-3f, 5e-4f, 2e-4f}) {
    MeshData mesh = strip({{0, 0}, {10, 0}});
    append(
        mesh,
        strip({{6 + size, 0}, {6, size}, {6, 1}, {9, 1}, {9, size}, {9 - size, 0}, {6 + size, 0}}));
    const SurfacePoint begin = pointAt(mesh, 1.02, 0.3);
    const auto up = findProfile(mesh, begin, pointAt(mesh, 8.02, 0.3, 1.0));
    EXPECT_TRUE(up.connected) << size;
    EXPECT_NEAR(up.heights().surface, 8.0, 0.005) << size;
    const auto over = findProfile(mesh, begin, pointAt(mesh, 9.62, 0.3));
    EXPECT_TRUE(over.connected) << size;
    EXPECT_NEAR(over.heights().surface, 8.6 + 2.0, 0.01) << size;
  }
}

TEST(SurfaceProfile, a_flat_wedge_stands_on_a_floor)
{
  MeshData mesh = strip({{0, 0}, {10, 0}});
  append(mesh, strip({{2, 0}, {8, 0.3f}, {8, 0}, {2, 0}}));  // 2.9 degrees
  const SurfacePoint begin = pointAt(mesh, 1.0, 0.3);
  const auto up = findProfile(mesh, begin, pointAt(mesh, 7.0, 0.3, 0.25));
  EXPECT_TRUE(up.connected);
  EXPECT_NEAR(up.heights().surface, 1.0 + std::hypot(5.0, 0.25), 1e-5);
  const auto over = findProfile(mesh, begin, pointAt(mesh, 9.0, 0.3));
  EXPECT_NEAR(over.heights().highest, 0.3, 1e-5);
}

TEST(SurfaceProfile, surfaces_do_not_end_where_the_line_does)
{
  // A sheet that nowhere ends on the floor below it, half a millimeter above.
  MeshData mesh = terrain(4, [](double, double) { return 0.0; });
  addQuad(mesh, {{{-1, -1, 5e-4f}, {1, -1, 5e-4f}, {1, 1, 5e-4f}, {-1, 1, 5e-4f}}});
  for (const double end : {0.45, 0.5, 0.5005}) {  // at an edge, and beside it
    const auto profile = findProfile(mesh, pointAt(mesh, -end, 0.3), pointAt(mesh, end, 0.3, 5e-4));
    EXPECT_FALSE(profile.connected) << end;
    EXPECT_NEAR(profile.heights().highest, 5e-4, 1e-6);
  }
}

TEST(SurfaceProfile, stairs_of_boxes_that_stand_on_a_floor)
{
  MeshData mesh;
  addBox(mesh, {-2, 7, -0.3f}, {12, 11, 0});
  for (int i = 0; i < 10; ++i) {
    const auto at = [](double x) { return static_cast<float>(x); };
    addBox(mesh, {at(2 + 0.3 * i), 8, 0}, {at(2.3 + 0.3 * i), 10, at(0.17 * (i + 1))});
  }
  addBox(mesh, {5, 8, 0}, {10, 10, 1.7f});
  const auto profile = findProfile(mesh, pointAt(mesh, 0.02, 8.96), pointAt(mesh, 8.02, 8.96, 1.7));
  ASSERT_TRUE(profile.connected);
  EXPECT_NEAR(profile.heights().surface, 9.7, 1e-4);
  EXPECT_NEAR(profile.heights().ascent, 1.7, 1e-4);
  for (const auto& point : profile.pieces[0]) {
    const double steps = (0.02 + point.distance - 2.0) / 0.3;
    const auto height = [](double step) { return 0.17 * std::clamp(std::floor(step), 0.0, 10.0); };
    EXPECT_GE(point.z, height(steps + 1.0 - 1e-3) - 1e-4) << point.distance;
    EXPECT_LE(point.z, height(steps + 1.0 + 1e-3) + 1e-4) << point.distance;
  }
}

TEST(SurfaceProfile, points_of_all_generated_meshes_are_on_them)
{
  for (const char* name : {"sphere", "torus", "two_storeys", "hole", "jittered_plane"}) {
    SCOPED_TRACE(name);
    const MeshData mesh = world(name);
    const auto box = [&](unsigned axis) {
      float low = 1e9f, high = -1e9f;
      for (const auto& vertex : mesh.vertices) {
        low = std::min(low, vertex.position[axis]);
        high = std::max(high, vertex.position[axis]);
      }
      return std::make_pair(low, high);
    };
    for (std::uint32_t from = 0; from < mesh.faceCount(); from += 7) {
      const std::uint32_t to = static_cast<std::uint32_t>((from * 31 + 11) % mesh.faceCount());
      const auto middle = [&](std::uint32_t face) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (unsigned corner = 0; corner < 3; ++corner) {
          sum += rviz_mesh_plugin::vectorOf(rviz_mesh_plugin::cornerOf(mesh, face, corner)) / 3.0;
        }
        return SurfacePoint{face, rviz_mesh_plugin::arrayOf(sum)};
      };
      const auto a = middle(from), b = middle(to);
      if (std::hypot(a.position[0] - b.position[0], a.position[1] - b.position[1]) < 1e-3) {
        continue;
      }
      const auto profile = findProfile(mesh, a, b);
      ASSERT_FALSE(profile.pieces.empty());
      EXPECT_NEAR(profile.pieces.front().front().z, a.position[2], 1e-6);
      expectOnMesh(mesh, profile);
      EXPECT_GE(profile.heights().lowest, box(2).first - 1e-5);
      EXPECT_LE(profile.heights().highest, box(2).second + 1e-5);
      if (profile.connected) {
        // No shorter than the straight line between the two.
        EXPECT_GE(profile.heights().surface,
                  rviz_mesh_plugin::distance(a.position, b.position) - 1e-6);
        EXPECT_NEAR(profile.pieces.back().back().z, b.position[2], 1e-6);
        EXPECT_TRUE(profile.gaps().empty());
      }
    }
  }
}

TEST(SurfaceProfile, what_is_refused_and_given_up)
{
  const MeshData mesh = terrain(3, [](double x, double y) { return x * y; });
  const SurfacePoint point = pointAt(mesh, 0.2, 0.1);
  EXPECT_THROW(findProfile(mesh, point, point), std::invalid_argument);
  const std::atomic<bool> cancel{true};
  EXPECT_THROW(findProfile(mesh, point, pointAt(mesh, 0.3, 0.3), &cancel),
               rviz_mesh_plugin::Canceled);
}
