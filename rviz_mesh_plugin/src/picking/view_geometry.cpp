#include "picking/view_geometry.h"

#include <cmath>

#include <OgreCamera.h>
#include <OgreViewport.h>
#include <rviz/viewport_mouse_event.h>
#include <Eigen/LU>

#include "base/vectors.h"
#include "selection/selection_regions.h"

namespace rviz_mesh_plugin {
namespace {

/// In a parallel projection, the eye is so many times the size of the mesh away.
constexpr double FAR_AWAY = 1e4;

using Projection = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

Eigen::Isometry3d poseOf(const FramePose& pose)
{
  const Ogre::Quaternion& q = pose.orientation;
  return Eigen::Translation3d(pose.position.x, pose.position.y, pose.position.z) *
         Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

Eigen::Isometry3d poseOf(const Ogre::Camera& camera)
{
  return poseOf(FramePose{camera.getDerivedPosition(), camera.getDerivedOrientation()});
}

Projection projectionOf(const Ogre::Camera& camera)
{
  using OgreMatrix = Eigen::Matrix<Ogre::Real, 4, 4, Eigen::RowMajor>;
  return Eigen::Map<const OgreMatrix>(camera.getProjectionMatrix()[0]).cast<double>();
}

/// The point that a matrix takes to this one of the picture; not finite where there is none.
Eigen::Vector3d unproject(const Projection& matrix, const PicturePoint& point, double z)
{
  const Eigen::Vector4d in_picture(point[0], point[1], z, 1.0);
  const Eigen::Vector4d in_space = matrix.partialPivLu().solve(in_picture);
  return in_space.hnormalized();
}

}  // namespace

mesh_map::Ray cursorRay(const rviz::ViewportMouseEvent& event)
{
  return event.viewport ? rayThrough({event.x + 0.5, event.y + 0.5}, *event.viewport)
                        : mesh_map::Ray();  // with the direction 0, which hits nothing
}

mesh_map::Ray rayThrough(const std::array<double, 2>& pixels, const Ogre::Viewport& viewport)
{
  mesh_map::Ray ray;
  const Ogre::Camera* camera = viewport.getCamera();
  if (!camera || viewport.getActualWidth() <= 0 || viewport.getActualHeight() <= 0) {
    return ray;
  }
  const PicturePoint cursor = pointOf(pixels, viewport);
  const Projection projection = projectionOf(*camera);
  const Eigen::Vector3d near = unproject(projection, cursor, -1.0);
  const Eigen::Vector3d along = unproject(projection, cursor, 0.0) - near;
  const double length = along.norm();
  if (std::isfinite(length) && length > 0.0) {
    const Eigen::Isometry3d pose = poseOf(*camera);
    ray.origin = arrayOf(pose * near);
    ray.direction = arrayOf(pose.linear() * (along / length));
  }
  return ray;
}

mesh_map::Ray rayInMesh(const mesh_map::Ray& ray, const ShownMesh& mesh)
{
  const Eigen::Isometry3d to_mesh = poseOf(mesh).inverse();
  return {arrayOf(to_mesh * vectorOf(ray.origin)),
          arrayOf(to_mesh.linear() * vectorOf(ray.direction)), ray.max_distance};
}

std::array<double, 3> pointInFixedFrame(const std::array<double, 3>& point, const ShownMesh& mesh)
{
  return arrayOf(poseOf(mesh) * vectorOf(point));
}

std::array<double, 3> directionInFixedFrame(const std::array<double, 3>& direction,
                                            const ShownMesh& mesh)
{
  return arrayOf(poseOf(mesh).linear() * vectorOf(direction));
}

std::array<double, 3> upInMesh(const ShownMesh& mesh)
{
  return arrayOf(poseOf(mesh).linear().transpose() * Eigen::Vector3d::UnitZ());
}

std::array<double, 16> meshToClip(const Ogre::Camera& camera, const ShownMesh& mesh)
{
  std::array<double, 16> matrix;
  Eigen::Map<Projection>(matrix.data()) =
      projectionOf(camera) * (poseOf(camera).inverse() * poseOf(mesh)).matrix();
  return matrix;
}

std::array<double, 3> eyeInMesh(const Ogre::Camera& camera, const ShownMesh& mesh)
{
  const Eigen::Isometry3d camera_to_mesh = poseOf(mesh).inverse() * poseOf(camera);
  if (projectionOf(camera)(3, 2) != 0.0) {  // perspective: w depends on the depth
    return arrayOf(camera_to_mesh.translation());
  }
  const Eigen::Vector3d lower = vectorOf(mesh.mesh->lower), upper = vectorOf(mesh.mesh->upper);
  const double size = (upper - lower).maxCoeff();
  const double distance = FAR_AWAY * (size > 0.0 ? size : 1.0);
  return arrayOf((lower + upper) / 2.0 + distance * camera_to_mesh.linear().col(2));
}

}  // namespace rviz_mesh_plugin
