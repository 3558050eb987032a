#include "picking/view_geometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <OgreCamera.h>
#include <OgreViewport.h>
#include <rviz/viewport_mouse_event.h>

namespace rviz_mesh_plugin {
namespace {

/// In a parallel projection, the eye is so many times the size of the mesh away.
constexpr double FAR_AWAY = 1e4;

using Vector = std::array<double, 3>;
using Matrix = std::array<double, 16>;

/// A rotation (by row) and where the origin goes.
struct Pose
{
  std::array<Vector, 3> rotation;
  Vector origin;
};

Pose poseOf(const Ogre::Vector3& position, const Ogre::Quaternion& orientation)
{
  double w = orientation.w, x = orientation.x, y = orientation.y, z = orientation.z;
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  w /= length;
  x /= length;
  y /= length;
  z /= length;
  return {{{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}},
          {position.x, position.y, position.z}};
}

Pose poseOf(const ShownMesh& mesh)
{
  return poseOf(mesh.position, mesh.orientation);
}

Pose poseOf(const Ogre::Camera& camera)
{
  return poseOf(camera.getDerivedPosition(), camera.getDerivedOrientation());
}

Vector rotated(const Pose& pose, const Vector& v)
{
  Vector result{};
  for (unsigned i = 0; i < 3; ++i) {
    result[i] =
        pose.rotation[i][0] * v[0] + pose.rotation[i][1] * v[1] + pose.rotation[i][2] * v[2];
  }
  return result;
}

Vector moved(const Pose& pose, const Vector& v)
{
  const Vector turned = rotated(pose, v);
  return {turned[0] + pose.origin[0], turned[1] + pose.origin[1], turned[2] + pose.origin[2]};
}

Pose inverse(const Pose& pose)
{
  Pose result{};
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned j = 0; j < 3; ++j) {
      result.rotation[i][j] = pose.rotation[j][i];
    }
  }
  const Vector origin = rotated(result, pose.origin);
  result.origin = {-origin[0], -origin[1], -origin[2]};
  return result;
}

Matrix matrixOf(const Pose& pose)
{
  Matrix matrix{};
  for (unsigned i = 0; i < 3; ++i) {
    std::copy(pose.rotation[i].begin(), pose.rotation[i].end(), &matrix[4 * i]);
    matrix[4 * i + 3] = pose.origin[i];
  }
  matrix[15] = 1.0;
  return matrix;
}

Matrix projectionOf(const Ogre::Camera& camera)
{
  const Ogre::Matrix4& projection = camera.getProjectionMatrix();
  Matrix matrix;
  for (unsigned i = 0; i < 16; ++i) {
    matrix[i] = projection[i / 4][i % 4];
  }
  return matrix;
}

Matrix product(const Matrix& a, const Matrix& b)
{
  Matrix result{};
  for (unsigned i = 0; i < 16; ++i) {
    for (unsigned k = 0; k < 4; ++k) {
      result[i] += a[4 * (i / 4) + k] * b[4 * k + i % 4];
    }
  }
  return result;
}

/// The point that a matrix takes to this one of the picture; not finite where there is none.
Vector unproject(Matrix matrix, double x, double y, double z)
{
  std::array<double, 4> point{x, y, z, 1.0};
  for (unsigned column = 0; column < 4; ++column) {
    unsigned pivot = column;
    for (unsigned row = column + 1; row < 4; ++row) {
      if (std::abs(matrix[4 * row + column]) > std::abs(matrix[4 * pivot + column])) {
        pivot = row;
      }
    }
    std::swap_ranges(&matrix[4 * column], &matrix[4 * column] + 4, &matrix[4 * pivot]);
    std::swap(point[column], point[pivot]);
    for (unsigned row = 0; row < 4; ++row) {
      if (row != column) {
        const double factor = matrix[4 * row + column] / matrix[4 * column + column];
        for (unsigned i = column; i < 4; ++i) {
          matrix[4 * row + i] -= factor * matrix[4 * column + i];
        }
        point[row] -= factor * point[column];
      }
    }
  }
  for (unsigned i = 0; i < 4; ++i) {
    point[i] /= matrix[5 * i];
  }
  return {point[0] / point[3], point[1] / point[3], point[2] / point[3]};
}

}  // namespace

mesh_map::Ray cursorRay(const rviz::ViewportMouseEvent& event)
{
  mesh_map::Ray ray;  // with the direction 0, which hits nothing
  const Ogre::Viewport* viewport = event.viewport;
  const Ogre::Camera* camera = viewport ? viewport->getCamera() : nullptr;
  if (!camera || viewport->getActualWidth() <= 0 || viewport->getActualHeight() <= 0) {
    return ray;
  }
  const double x =
      2.0 * (event.x + 0.5 - viewport->getActualLeft()) / viewport->getActualWidth() - 1.0;
  const double y =
      1.0 - 2.0 * (event.y + 0.5 - viewport->getActualTop()) / viewport->getActualHeight();
  const Matrix projection = projectionOf(*camera);
  const Vector near = unproject(projection, x, y, -1.0);
  const Vector middle = unproject(projection, x, y, 0.0);
  Vector along{middle[0] - near[0], middle[1] - near[1], middle[2] - near[2]};
  const double length = std::hypot(along[0], along[1], along[2]);
  if (std::isfinite(length) && length > 0.0) {
    for (double& coordinate : along) {
      coordinate /= length;
    }
    const Pose pose = poseOf(*camera);
    ray.origin = moved(pose, near);
    ray.direction = rotated(pose, along);
  }
  return ray;
}

Ogre::Ray viewRay(const rviz::ViewportMouseEvent& event)
{
  const auto vector = [](const Vector& v) {
    return Ogre::Vector3(static_cast<Ogre::Real>(v[0]), static_cast<Ogre::Real>(v[1]),
                         static_cast<Ogre::Real>(v[2]));
  };
  const mesh_map::Ray ray = cursorRay(event);
  return Ogre::Ray(vector(ray.origin), vector(ray.direction));
}

mesh_map::Ray rayInMesh(const mesh_map::Ray& ray, const ShownMesh& mesh)
{
  const Pose pose = inverse(poseOf(mesh));
  return {moved(pose, ray.origin), rotated(pose, ray.direction), ray.max_distance};
}

std::array<double, 3> pointInFixedFrame(const std::array<double, 3>& point, const ShownMesh& mesh)
{
  return moved(poseOf(mesh), point);
}

std::array<double, 3> directionInFixedFrame(const std::array<double, 3>& direction,
                                            const ShownMesh& mesh)
{
  return rotated(poseOf(mesh), direction);
}

std::array<double, 16> meshToClip(const Ogre::Camera& camera, const ShownMesh& mesh)
{
  const Matrix mesh_to_camera = product(matrixOf(inverse(poseOf(camera))), matrixOf(poseOf(mesh)));
  return product(projectionOf(camera), mesh_to_camera);
}

std::array<double, 3> eyeInMesh(const Ogre::Camera& camera, const ShownMesh& mesh)
{
  const Pose camera_pose = poseOf(camera);
  const Pose to_mesh = inverse(poseOf(mesh));
  const Matrix projection = projectionOf(camera);
  if (projection[14] != 0.0) {  // perspective: w depends on the depth
    return moved(to_mesh, camera_pose.origin);
  }
  const Vector backwards = rotated(to_mesh, rotated(camera_pose, {0.0, 0.0, 1.0}));
  Vector middle{};
  double size = 0.0;
  for (unsigned i = 0; i < 3; ++i) {
    middle[i] = 0.5 * (static_cast<double>(mesh.mesh->lower[i]) + mesh.mesh->upper[i]);
    size = std::max(size, static_cast<double>(mesh.mesh->upper[i]) - mesh.mesh->lower[i]);
  }
  const double distance = FAR_AWAY * (size > 0.0 ? size : 1.0);
  return {middle[0] + distance * backwards[0], middle[1] + distance * backwards[1],
          middle[2] + distance * backwards[2]};
}

}  // namespace rviz_mesh_plugin
