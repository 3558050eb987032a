#include "rendering/level_choice.h"

#include <cmath>

#include <OgreCamera.h>
#include <OgreViewport.h>

namespace rviz_mesh_plugin {

PixelSize pixelSize(const Ogre::Camera& camera)
{
  PixelSize size;
  const Ogre::Viewport* viewport = camera.getViewport();
  // RViz sets orthographic projections as matrices of its own: only the matrix tells.
  const Ogre::Matrix4& projection = camera.getProjectionMatrix();
  const float scale = std::fabs(static_cast<float>(projection[1][1]));
  if (!viewport || viewport->getActualHeight() <= 0 || !(scale > 0.0f)) {
    return size;
  }
  size.meters = 2.0f / (scale * static_cast<float>(viewport->getActualHeight()));
  size.grows_with_distance = projection[3][3] == 0;
  return size;
}

std::size_t chooseLevel(const std::vector<float>& cell_sizes, float largest_cell)
{
  std::size_t level = 0;
  while (level + 1 < cell_sizes.size() && cell_sizes[level + 1] <= largest_cell) {
    ++level;
  }
  return level;
}

}  // namespace rviz_mesh_plugin
