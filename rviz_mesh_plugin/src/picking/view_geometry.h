#pragma once

#include <array>

#ifndef Q_MOC_RUN
#include <mesh_map/bvh/rays/bvh_rays.h>

#include "mesh_view/shown_mesh.h"
#endif

namespace Ogre {
class Camera;
class Viewport;
}  // namespace Ogre

namespace rviz {
class ViewportMouseEvent;
}

namespace rviz_mesh_plugin {

/// What a camera of RViz has to do with the coordinates of a mesh, in double precision.

inline Ogre::Vector3 ogreVector(const std::array<double, 3>& v)
{
  return Ogre::Vector3(static_cast<Ogre::Real>(v[0]), static_cast<Ogre::Real>(v[1]),
                       static_cast<Ogre::Real>(v[2]));
}

/// From the near plane of the camera through the middle of the pixel under the cursor, in the fixed
/// frame; the direction has length 1. Hits nothing where there is no camera.
mesh_map::Ray cursorRay(const rviz::ViewportMouseEvent& event);

/// The same through any point of a picture, in pixels: the middle of one is its number and a half.
mesh_map::Ray rayThrough(const std::array<double, 2>& pixels, const Ogre::Viewport& viewport);

/// A ray in the fixed frame in the coordinates of a mesh.
mesh_map::Ray rayInMesh(const mesh_map::Ray& ray, const ShownMesh& mesh);

/// A point (or direction) of the mesh in the fixed frame.
std::array<double, 3> pointInFixedFrame(const std::array<double, 3>& point, const ShownMesh& mesh);
std::array<double, 3> directionInFixedFrame(const std::array<double, 3>& direction,
                                            const ShownMesh& mesh);

/// What is up in the fixed frame (its z), in the coordinates of a mesh; of length 1.
std::array<double, 3> upInMesh(const ShownMesh& mesh);

/// From the coordinates of the mesh to clip space as OpenGL has it (-w <= z <= w): row-major, for
/// column vectors.
std::array<double, 16> meshToClip(const Ogre::Camera& camera, const ShownMesh& mesh);

/// Where a mesh is seen from, in its own coordinates. In a parallel projection: a point so far
/// behind the camera that lines of sight to the mesh differ by about 1e-4.
std::array<double, 3> eyeInMesh(const Ogre::Camera& camera, const ShownMesh& mesh);

}  // namespace rviz_mesh_plugin
