#include "tools/surface_pose.h"

#include <cmath>

#include "base/vectors.h"

namespace rviz_mesh_plugin {
namespace {

using Vector = Eigen::Vector3d;

/// Shorter ways from the pose to the cursor are no direction, in meters.
constexpr double NO_DRAG = 1e-3;
/// The sine of an angle below which a view is straight onto the surface, and a ray runs along it.
constexpr double STRAIGHT = 1e-3;
constexpr double ALONG = 1e-9;
/// Normals with a smaller part upwards are horizontal.
constexpr double HORIZONTAL = 1e-6;

/// The part of a vector in the plane across a normal of length 1.
Vector inPlane(const Vector& v, const Vector& normal)
{
  return v - v.dot(normal) * normal;
}

/// +1 or -1, by which the normal shows to the side that is asked for.
double turned(const Vector& normal, const mesh_map::Ray& ray, const SurfaceSide& side)
{
  if (side.of == SurfaceSide::UP && std::abs(normal[2]) > HORIZONTAL) {
    return normal[2] < 0.0 ? -1.0 : 1.0;
  }
  return normal.dot(vectorOf(ray.direction)) > 0.0 ? -1.0 : 1.0;
}

}  // namespace

std::array<double, 4> quaternionOf(const SurfacePose& pose)
{
  Eigen::Matrix3d axes;
  axes << vectorOf(pose.x), vectorOf(pose.y), vectorOf(pose.z);
  const Eigen::Quaterniond q = Eigen::Quaterniond(axes).normalized();
  return {q.x(), q.y(), q.z(), q.w()};
}

SurfacePoseDrag::SurfacePoseDrag(const std::array<double, 3>& point,
                                 const std::array<double, 3>& normal, const mesh_map::Ray& ray,
                                 const ViewAxes& view, const SurfaceSide& side)
{
  pose_.position = point;
  const Vector unit = vectorOf(normal).normalized();
  pose_.z = arrayOf((side.switched ? -1.0 : 1.0) * turned(unit, ray, side) * unit);
  turnAlong(view);
}

void SurfacePoseDrag::setX(const std::array<double, 3>& along)
{
  // Twice: what rounding leaves across the plane counts where little is in it.
  const Vector z = vectorOf(pose_.z);
  const Vector x = inPlane(inPlane(vectorOf(along), z).normalized(), z).normalized();
  pose_.x = arrayOf(x);
  pose_.y = arrayOf(z.cross(x));
}

void SurfacePoseDrag::turnAlong(const ViewAxes& view)
{
  const bool straight = inPlane(vectorOf(view.forward), vectorOf(pose_.z)).norm() < STRAIGHT;
  setX(straight ? view.up : view.forward);
}

void SurfacePoseDrag::turnTowards(const mesh_map::Ray& ray, const ViewAxes& view)
{
  const Vector z = vectorOf(pose_.z), origin = vectorOf(ray.origin);
  const Vector direction = vectorOf(ray.direction), position = vectorOf(pose_.position);
  const double slope = direction.dot(z);
  const double height = (position - origin).dot(z);
  if (!(std::abs(slope) > ALONG * direction.norm()) || !(height / slope > 0.0)) {
    return;
  }
  const Vector way = inPlane(origin + height / slope * direction - position, z);
  if (way.norm() < NO_DRAG) {
    turnAlong(view);
  } else if (std::isfinite(way.norm())) {
    setX(arrayOf(way));
  }
}

}  // namespace rviz_mesh_plugin
