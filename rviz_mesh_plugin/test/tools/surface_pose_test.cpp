#include "tools/surface_pose.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

using rviz_mesh_plugin::quaternionOf;
using rviz_mesh_plugin::SurfacePose;
using rviz_mesh_plugin::SurfacePoseDrag;
using rviz_mesh_plugin::SurfaceSide;
using rviz_mesh_plugin::ViewAxes;
using Vector = std::array<double, 3>;

namespace {

double dot(const Vector& a, const Vector& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector plus(const Vector& a, double factor, const Vector& b)
{
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}
Vector cross(const Vector& a, const Vector& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vector unit(const Vector& v)
{
  return plus({0, 0, 0}, 1.0 / std::sqrt(dot(v, v)), v);
}

void expectNear(const Vector& a, const Vector& b, double error = 1e-12)
{
  for (unsigned i = 0; i < 3; ++i) {
    EXPECT_NEAR(a[i], b[i], error) << i;
  }
}

/// The axes that a quaternion stands for: the columns of its matrix.
void expectSame(const SurfacePose& pose, const std::array<double, 4>& q)
{
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  ASSERT_NEAR(x * x + y * y + z * z + w * w, 1.0, 1e-14);
  expectNear(pose.x, {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)});
  expectNear(pose.y, {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)});
  expectNear(pose.z, {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)});
}

void expectValid(const SurfacePose& pose)
{
  for (const Vector& axis : {pose.x, pose.y, pose.z}) {
    ASSERT_NEAR(dot(axis, axis), 1.0, 1e-12);
  }
  ASSERT_NEAR(dot(pose.x, pose.z), 0.0, 1e-12);
  expectNear(cross(pose.z, pose.x), pose.y);
  expectSame(pose, quaternionOf(pose));
}

struct Random
{
  std::mt19937 engine{7};
  double number(double lower = -1.0, double upper = 1.0)
  {
    return std::uniform_real_distribution<double>(lower, upper)(engine);
  }
  Vector direction()
  {
    Vector v;
    do {
      v = {number(), number(), number()};
    } while (dot(v, v) > 1.0 || dot(v, v) < 1e-3);
    return unit(v);
  }
  /// A camera that looks along a direction.
  ViewAxes view(const Vector& forward)
  {
    Vector up;
    do {
      up = direction();
      up = plus(up, -dot(up, forward), forward);
    } while (dot(up, up) < 0.01);
    return {forward, unit(up)};
  }
};

}  // namespace

TEST(SurfacePose, looks_at_the_cursor_on_planes_of_any_kind_from_any_side)
{
  Random random;
  for (int i = 0; i < 20000; ++i) {
    const Vector normal = random.direction();
    const Vector point = plus({0, 0, 0}, std::pow(10.0, random.number(-3, 4)), random.direction());
    const Vector eye = plus(point, random.number(0.5, 50.0), random.direction());
    if (std::abs(dot(plus(eye, -1, point), normal)) < 1e-3) {
      continue;
    }
    const Vector in_plane = unit(cross(normal, random.direction()));
    const Vector cursor = plus(point, random.number(0.002, 20.0), in_plane);
    const ViewAxes view = random.view(unit(plus(point, -1, eye)));
    SurfaceSide side;
    side.of = random.number() > 0 ? SurfaceSide::VIEWER : SurfaceSide::UP;
    side.switched = random.number() > 0;
    SurfacePoseDrag drag(point, plus({0, 0, 0}, random.number(0.1, 9), normal),
                         {eye, plus(point, -1, eye)}, view, side);
    drag.turnTowards({eye, plus(cursor, -1, eye)}, view);
    expectValid(drag.pose());
    EXPECT_EQ(drag.pose().position, point);
    // Coordinates have 16 digits, of which the way takes those that are left.
    expectNear(drag.pose().x, in_plane, 1e-8);
    EXPECT_NEAR(std::abs(dot(drag.pose().z, normal)), 1.0, 1e-12);
    const bool outward = side.of == SurfaceSide::UP ? drag.pose().z[2] > 0
                                                    : dot(plus(eye, -1, point), drag.pose().z) > 0;
    EXPECT_NE(outward, side.switched);
    if (HasFailure()) {
      FAIL() << "sample " << i;
    }
  }
}

TEST(SurfacePose, switched_turns_y_and_z_over_and_keeps_x)
{
  const ViewAxes view{unit({1, 0.5, -1}), unit({1, 0.5, 1.25})};
  const mesh_map::Ray ray{{-3, 0, 3}, {1, 0, -1}};
  const Vector normal = unit({0.3, 0.2, 1});
  SurfacePoseDrag drag({0, 0, 0}, normal, ray, view, {SurfaceSide::VIEWER, false});
  SurfacePoseDrag other({0, 0, 0}, normal, ray, view, {SurfaceSide::VIEWER, true});
  expectNear(drag.pose().x, other.pose().x);
  expectNear(drag.pose().y, plus({0, 0, 0}, -1, other.pose().y));
  expectNear(drag.pose().z, plus({0, 0, 0}, -1, other.pose().z));
}

TEST(SurfacePose, without_a_drag_it_looks_as_the_camera_does)
{
  Random random;
  for (int i = 0; i < 5000; ++i) {
    const Vector normal = random.direction();
    const Vector forward = random.direction();
    const ViewAxes view = random.view(forward);
    if (std::abs(dot(normal, forward)) > 0.9999) {
      continue;
    }
    const SurfacePoseDrag drag({1, 2, 3}, normal, {{0, 0, 0}, forward}, view, {});
    expectValid(drag.pose());
    expectNear(drag.pose().x, unit(plus(forward, -dot(forward, normal), normal)), 1e-9);
    if (HasFailure()) {
      FAIL() << "sample " << i;
    }
  }
}

TEST(SurfacePose, straight_down_it_looks_to_the_top_of_the_picture)
{
  const ViewAxes view{{1e-7, -1e-7, -1}, {0.6, 0.8, 0}};
  SurfacePoseDrag drag({0, 0, 0}, {0, 0, -2}, {{0, 0, 5}, {0, 0, -1}}, view, {});
  expectValid(drag.pose());
  expectNear(drag.pose().x, {0.6, 0.8, 0}, 1e-6);
  expectNear(drag.pose().z, {0, 0, 1});
  // A cursor within a millimeter is no drag; beyond it is.
  drag.turnTowards({{0, 0, 5}, {-0.0009, 0, -5}}, view);
  expectNear(drag.pose().x, {0.6, 0.8, 0}, 1e-6);
  drag.turnTowards({{0, 0, 5}, {-0.0011, 0, -5}}, view);
  expectNear(drag.pose().x, {-1, 0, 0}, 1e-6);
}

TEST(SurfacePose, rays_that_do_not_meet_the_plane_change_nothing)
{
  const ViewAxes view{unit({1, 0, -0.2}), unit({0.2, 0, 1})};
  const Vector eye{-5, 0, 1};
  SurfacePoseDrag drag({0, 0, 0}, {0, 0, 1}, {eye, unit({5, 0, -1})}, view, {});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector headings[] = {{1, 0, 0}, {0, -1, 0}};
  for (const Vector& heading : headings) {  // that of the view, then the last one
    for (const Vector& direction :
         {Vector{1, 1, 0}, {1, 1, 0.3}, {1, 1, 1e-12}, {0, 0, 0}, {nan, 0, 0}}) {
      drag.turnTowards({eye, direction}, view);
      expectValid(drag.pose());
      expectNear(drag.pose().x, heading);
    }
    drag.turnTowards({eye, {5, -3, -1}}, view);
  }
}

TEST(SurfacePose, edge_on_it_is_valid_however_flat_the_ray)
{
  for (const double slope : {1e-2, 1e-5, 1e-8, 1e-10, 1e-14, 0.0}) {
    const ViewAxes view{unit({1, 0, -slope}), {0, 0, 1}};
    SurfacePoseDrag drag({0, 0, 0}, {0, 0, 1}, {{-1, 0, slope}, {1, 0, -slope}}, view, {});
    drag.turnTowards({{-1, 0, slope}, {1, 1e-4, -slope / 2}}, view);
    expectValid(drag.pose());
    expectNear(drag.pose().z, {0, 0, 1});
    EXPECT_GT(drag.pose().x[0], 0.999);
  }
}

TEST(SurfacePose, up_falls_back_to_the_viewer_on_walls)
{
  for (const double side : {1.0, -1.0}) {
    const ViewAxes view{{-side, 0, 0}, {0, 0, 1}};
    const SurfacePoseDrag drag({0, 0, 0}, {1, 0, 0}, {{side, 0, 0}, {-side, 0, 0}}, view,
                               {SurfaceSide::UP, false});
    expectNear(drag.pose().z, {side, 0, 0});
    expectNear(drag.pose().x, {0, 0, 1});
  }
}

TEST(SurfacePose, every_branch_of_the_quaternion_is_of_length_one)
{
  Random random;
  for (int i = 0; i < 20000; ++i) {
    SurfacePose pose;
    pose.z = random.direction();
    pose.x = unit(cross(pose.z, random.direction()));
    pose.y = cross(pose.z, pose.x);
    expectSame(pose, quaternionOf(pose));
  }
  for (const auto& half_turn : {Vector{1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, 1, 1}}) {
    const SurfacePose pose{{}, {half_turn[0], 0, 0}, {0, half_turn[1], 0}, {0, 0, half_turn[2]}};
    expectSame(pose, quaternionOf(pose));
  }
}
