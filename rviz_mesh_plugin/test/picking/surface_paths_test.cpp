#include "picking/surface_paths.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "conversion/mesh_conversion.h"
#include "support/meshes.h"
#include "threads/cancellation.h"

using rviz_mesh_plugin::findPath;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::MeshDataConstPtr;
using rviz_mesh_plugin::SurfacePath;
using rviz_mesh_plugin::SurfacePoint;
using Vector = std::array<double, 3>;

namespace {

/// The face over or below (x, y), of those that `wanted` takes, and the point of it there.
template <class Wanted>
SurfacePoint at(const MeshData& mesh, double x, double y, const Wanted& wanted)
{
  for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
    std::array<Vector, 3> p;
    for (unsigned k = 0; k < 3; ++k) {
      const auto& position = mesh.vertices[mesh.indices[3 * face + k]].position;
      p[k] = {position[0], position[1], position[2]};
    }
    const double area =
        (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    const double b =
        ((x - p[0][0]) * (p[2][1] - p[0][1]) - (y - p[0][1]) * (p[2][0] - p[0][0])) / area;
    const double c =
        ((p[1][0] - p[0][0]) * (y - p[0][1]) - (p[1][1] - p[0][1]) * (x - p[0][0])) / area;
    const double a = 1.0 - b - c;
    if (std::abs(area) > 1e-9 && std::min({a, b, c}) > -1e-12 && wanted(face)) {
      SurfacePoint point{face, {}};
      for (unsigned axis = 0; axis < 3; ++axis) {
        point.position[axis] = a * p[0][axis] + b * p[1][axis] + c * p[2][axis];
      }
      return point;
    }
  }
  throw std::logic_error("no face there");
}

SurfacePoint at(const MeshData& mesh, double x, double y)
{
  return at(mesh, x, y, [](std::uint32_t) { return true; });
}

double distance(const Vector& a, const Vector& b)
{
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void expectFromTo(const SurfacePath& way, const SurfacePoint& from, const SurfacePoint& to)
{
  ASSERT_TRUE(way.connected);
  ASSERT_GE(way.points.size(), 6u);
  for (unsigned i = 0; i < 3; ++i) {
    EXPECT_EQ(way.points[i], from.position[i]);
    EXPECT_EQ(way.points[way.points.size() - 3 + i], to.position[i]);
  }
}

MeshDataConstPtr flat(std::uint32_t cells)
{
  return rviz_mesh_plugin::convert(
      test_meshes::terrain(cells, [](double, double) { return 0.25; }));
}

/// Each face with vertices of its own, as where textures are cut.
mesh_msgs::MeshGeometryStamped torn(const mesh_msgs::MeshGeometryStamped& message)
{
  auto result = test_meshes::emptyMesh();
  for (const auto& face : message.mesh_geometry.faces) {
    const auto first = static_cast<std::uint32_t>(result.mesh_geometry.vertices.size());
    for (const auto vertex : face.vertex_indices) {
      result.mesh_geometry.vertices.push_back(message.mesh_geometry.vertices[vertex]);
    }
    test_meshes::addFace(result, first, first + 1, first + 2);
  }
  return result;
}

}  // namespace

TEST(SurfacePaths, straight_on_a_plane)
{
  const auto mesh = flat(23);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-0.999, 0.999);
  for (int i = 0; i < 50; ++i) {
    const SurfacePoint from = at(*mesh, number(random), number(random));
    const SurfacePoint to = at(*mesh, number(random), number(random));
    const SurfacePath way = findPath(*mesh, from, to);
    expectFromTo(way, from, to);
    EXPECT_NEAR(way.length, distance(from.position, to.position), 1e-6);
  }
}

TEST(SurfacePaths, within_a_face_and_to_the_same_point)
{
  const auto mesh = flat(1);
  const SurfacePoint from = at(*mesh, 0.3, -0.2);
  const SurfacePoint to = at(*mesh, 0.9, -0.7);
  ASSERT_EQ(from.face, to.face);
  const SurfacePath way = findPath(*mesh, from, to);
  expectFromTo(way, from, to);
  EXPECT_NEAR(way.length, distance(from.position, to.position), 1e-12);
  EXPECT_TRUE(findPath(*mesh, from, from).connected);
  EXPECT_EQ(findPath(*mesh, from, from).length, 0.0);
}

TEST(SurfacePaths, around_a_fold_it_is_the_unfolded_distance)
{
  // Flat for x < 0, and 45 degrees up from there: an edge of a box.
  const auto mesh = rviz_mesh_plugin::convert(
      test_meshes::terrain(20, [](double x, double) { return std::max(0.0, x); }));
  const SurfacePoint from = at(*mesh, -0.73, -0.61);
  const SurfacePoint to = at(*mesh, 0.52, 0.83);
  const SurfacePath way = findPath(*mesh, from, to);
  expectFromTo(way, from, to);
  EXPECT_NEAR(way.length, std::hypot(0.73 + 0.52 * std::sqrt(2.0), 1.44), 1e-6);
}

TEST(SurfacePaths, around_the_corner_of_a_box_it_is_the_shorter_of_the_unfoldings)
{
  // A cube of 2 m: its top is z = 1, its front y = -1, its right x = 1.
  auto message = test_meshes::emptyMesh();
  for (int i = 0; i < 8; ++i) {
    message.mesh_geometry.vertices.push_back(
        test_meshes::point((i & 1) * 2 - 1, (i & 2) - 1, (i & 4) / 2 - 1));
  }
  const unsigned quads[6][4] = {{4, 5, 7, 6}, {0, 1, 5, 4}, {1, 3, 7, 5},
                                {3, 2, 6, 7}, {2, 0, 4, 6}, {1, 0, 2, 3}};
  for (const auto& q : quads) {
    test_meshes::addFace(message, q[0], q[1], q[2]);
    test_meshes::addFace(message, q[0], q[2], q[3]);
  }
  const auto mesh = rviz_mesh_plugin::convert(message);
  const SurfacePoint from = at(*mesh, 0.2, -0.9, [](std::uint32_t face) { return face < 2; });
  // On the right side, at y = 0.1 and z = 0.5: face 4 has the corners (1,-1,-1), (1,1,-1), (1,1,1),
  // face 5 (1,-1,-1), (1,1,1), (1,-1,1).
  const SurfacePoint to{5, {1.0, 0.1, 0.5}};
  const double over_top = std::hypot(0.8 + 0.5, 1.0);
  const double over_front = std::hypot(0.1 + 0.5, 0.8 + 1.1);  // front turned up, right beside it
  const SurfacePath way = findPath(*mesh, from, to);
  expectFromTo(way, from, to);
  EXPECT_NEAR(way.length, std::min(over_top, over_front), 1e-6);
  const SurfacePoint low{4, {1.0, 0.9, -0.95}};
  const SurfacePath down = findPath(*mesh, from, low);
  EXPECT_NEAR(down.length, std::hypot(0.8 + 1.95, 1.8), 1e-6);
}

TEST(SurfacePaths, seams_are_no_borders)
{
  const auto message = test_meshes::terrain(12, [](double, double) { return 0.0; });
  const auto mesh = rviz_mesh_plugin::convert(torn(message));
  const SurfacePoint from = at(*mesh, -0.9, -0.4);
  const SurfacePoint to = at(*mesh, 0.8, 0.7);
  const SurfacePath way = findPath(*mesh, from, to);
  expectFromTo(way, from, to);
  EXPECT_NEAR(way.length, distance(from.position, to.position), 1e-6);
}

TEST(SurfacePaths, parts_that_do_not_touch_are_not_connected)
{
  auto message = test_meshes::terrain(8, [](double, double) { return 0.0; });
  const auto first = static_cast<std::uint32_t>(message.mesh_geometry.faces.size());
  const auto other = test_meshes::terrain(8, [](double, double) { return 1.0; });
  const auto vertices = static_cast<std::uint32_t>(message.mesh_geometry.vertices.size());
  for (const auto& vertex : other.mesh_geometry.vertices) {
    message.mesh_geometry.vertices.push_back(vertex);
  }
  for (const auto& face : other.mesh_geometry.faces) {
    const auto& v = face.vertex_indices;
    test_meshes::addFace(message, v[0] + vertices, v[1] + vertices, v[2] + vertices);
  }
  const auto mesh = rviz_mesh_plugin::convert(message);
  const SurfacePoint from = at(*mesh, 0.1, 0.2);
  const SurfacePoint above = at(*mesh, 0.1, 0.2, [&](std::uint32_t face) { return face >= first; });
  ASSERT_EQ(above.position[2], 1.0);
  const SurfacePath way = findPath(*mesh, from, above);
  EXPECT_FALSE(way.connected);
  EXPECT_TRUE(way.points.empty());
  EXPECT_TRUE(findPath(*mesh, above, at(*mesh, -0.4, 0.3, [&](std::uint32_t face) {
                return face >= first;
              })).connected);
}

TEST(SurfacePaths, is_given_up_on_demand)
{
  const auto mesh = flat(40);
  const std::atomic<bool> canceled{true};
  EXPECT_THROW(findPath(*mesh, at(*mesh, -0.9, -0.9), at(*mesh, 0.9, 0.9), &canceled),
               rviz_mesh_plugin::Canceled);
}

TEST(SurfacePaths, a_point_of_another_face_is_refused)
{
  const auto mesh = flat(4);
  SurfacePoint to = at(*mesh, 0.9, 0.9);
  to.face = 0;
  EXPECT_THROW(findPath(*mesh, at(*mesh, -0.1, 0.2), to), std::invalid_argument);
}
