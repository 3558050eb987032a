#pragma once

#include <cstddef>
#include <vector>

#include <OgrePrerequisites.h>

#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {

/// What one pixel of a camera's picture covers.
struct PixelSize
{
  float meters = 0.0f;  ///< at a distance of 1 m where it grows with the distance; 0: unknown
  bool grows_with_distance = false;

  float at(float distance) const { return grows_with_distance ? meters * distance : meters; }
};

/// Of the viewport that the camera draws into now; all projections, RViz's own orthographic one
/// too.
PixelSize pixelSize(const Ogre::Camera& camera);

/// The coarsest level of detail whose cells are not larger than @a largest_cell (meters); 0, the
/// full one, if there is none.
/// @param cell_sizes of each level, ascending
std::size_t chooseLevel(const std::vector<float>& cell_sizes, float largest_cell);

}  // namespace rviz_mesh_plugin
