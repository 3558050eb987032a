#include "tools/surface_pose.h"

#include <cmath>

namespace rviz_mesh_plugin {
namespace {

using Vector = std::array<double, 3>;

/// Shorter ways from the pose to the cursor are no direction, in meters.
constexpr double NO_DRAG = 1e-3;
/// The sine of an angle below which a view is straight onto the surface, and a ray runs along it.
constexpr double STRAIGHT = 1e-3;
constexpr double ALONG = 1e-9;
/// Normals with a smaller part upwards are horizontal.
constexpr double HORIZONTAL = 1e-6;

double dot(const Vector& a, const Vector& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double lengthOf(const Vector& v)
{
  return std::hypot(v[0], v[1], v[2]);
}

Vector cross(const Vector& a, const Vector& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// a + factor * b
Vector plus(const Vector& a, double factor, const Vector& b)
{
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

Vector scaled(const Vector& v, double factor)
{
  return {factor * v[0], factor * v[1], factor * v[2]};
}

/// The part of a vector in the plane across a normal of length 1.
Vector inPlane(const Vector& v, const Vector& normal)
{
  return plus(v, -dot(v, normal), normal);
}

/// +1 or -1, by which the normal shows to the side that is asked for.
double turned(const Vector& normal, const mesh_map::Ray& ray, const SurfaceSide& side)
{
  if (side.of == SurfaceSide::UP && std::abs(normal[2]) > HORIZONTAL) {
    return normal[2] < 0.0 ? -1.0 : 1.0;
  }
  return dot(normal, ray.direction) > 0.0 ? -1.0 : 1.0;
}

}  // namespace

std::array<double, 4> quaternionOf(const SurfacePose& pose)
{
  // Four times the squares of w, x, y, z: at least one is 1 or more, and the others follow from it.
  const Vector &x = pose.x, &y = pose.y, &z = pose.z;
  const double squares[4] = {1 + x[0] + y[1] + z[2], 1 + x[0] - y[1] - z[2], 1 - x[0] + y[1] - z[2],
                             1 - x[0] - y[1] + z[2]};
  unsigned largest = 0;
  for (unsigned i = 1; i < 4; ++i) {
    largest = squares[i] > squares[largest] ? i : largest;
  }
  const double wx = y[2] - z[1], wy = z[0] - x[2], wz = x[1] - y[0];
  const double xy = x[1] + y[0], xz = x[2] + z[0], yz = y[2] + z[1];
  const std::array<double, 4> by_largest[4] = {{wx, wy, wz, squares[0]},
                                               {squares[1], xy, xz, wx},
                                               {xy, squares[2], yz, wy},
                                               {xz, yz, squares[3], wz}};
  std::array<double, 4> q = by_largest[largest];
  const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  for (double& part : q) {
    part /= length;
  }
  return q;
}

SurfacePoseDrag::SurfacePoseDrag(const Vector& point, const Vector& normal,
                                 const mesh_map::Ray& ray, const ViewAxes& view,
                                 const SurfaceSide& side)
{
  pose_.position = point;
  const Vector unit = scaled(normal, 1.0 / lengthOf(normal));
  pose_.z = scaled(unit, (side.switched ? -1.0 : 1.0) * turned(unit, ray, side));
  turnAlong(view);
}

void SurfacePoseDrag::setX(const Vector& along)
{
  // Twice: what rounding leaves across the plane counts where little is in it.
  Vector x = inPlane(along, pose_.z);
  x = inPlane(scaled(x, 1.0 / lengthOf(x)), pose_.z);
  pose_.x = scaled(x, 1.0 / lengthOf(x));
  pose_.y = cross(pose_.z, pose_.x);
}

void SurfacePoseDrag::turnAlong(const ViewAxes& view)
{
  const bool straight = lengthOf(inPlane(view.forward, pose_.z)) < STRAIGHT;
  setX(straight ? view.up : view.forward);
}

void SurfacePoseDrag::turnTowards(const mesh_map::Ray& ray, const ViewAxes& view)
{
  const double slope = dot(ray.direction, pose_.z);
  const double height = dot(plus(pose_.position, -1.0, ray.origin), pose_.z);
  if (!(std::abs(slope) > ALONG * lengthOf(ray.direction)) || !(height / slope > 0.0)) {
    return;
  }
  const Vector cursor = plus(ray.origin, height / slope, ray.direction);
  const Vector way = inPlane(plus(cursor, -1.0, pose_.position), pose_.z);
  if (lengthOf(way) < NO_DRAG) {
    turnAlong(view);
  } else if (std::isfinite(lengthOf(way))) {
    setX(way);
  }
}

}  // namespace rviz_mesh_plugin
