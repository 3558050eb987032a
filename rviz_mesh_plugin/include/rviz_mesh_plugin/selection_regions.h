#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <mesh_map/region.h>

#include "rviz_mesh_plugin/face_selection.h"
#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/selection_gestures.h"

namespace Ogre {
class Camera;
class Viewport;
}  // namespace Ogre

namespace rviz_mesh_plugin {

/// What is selected in a picture, as parts of space.

using PicturePoint = std::array<double, 2>;

/// The middle of a pixel in normalized device coordinates (y up). @param viewport not empty
PicturePoint pointOf(const Pixel& pixel, const Ogre::Viewport& viewport);
std::vector<PicturePoint> pointsOf(const std::vector<Pixel>& pixels,
                                   const Ogre::Viewport& viewport);

/// What the camera sees between two corners in its picture.
/// @param mesh_to_clip see meshToClip()
mesh_map::ConvexRegion boxRegion(const PicturePoint& corner, const PicturePoint& opposite,
                                 const std::array<double, 16>& mesh_to_clip);

/// How many pixels a length has at a distance from the camera.
double pixelsOf(double length, double distance, const Ogre::Viewport& viewport);

/// Takes out the faces that are seen from behind (they are counterclockwise from the front), and
/// those seen edge-on.
void dropBackFaces(const MeshData& mesh, const std::array<double, 3>& eye,
                   FaceSelection::Faces& faces);

/// In square meters.
double faceArea(const MeshData& mesh, std::uint32_t face);

}  // namespace rviz_mesh_plugin
