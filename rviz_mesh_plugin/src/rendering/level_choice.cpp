#include "rendering/level_choice.h"

#include <algorithm>
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

float distanceToBox(const Ogre::Vector3& point, const std::array<float, 3>& lower,
                    const std::array<float, 3>& upper)
{
  float square = 0.0f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto value = static_cast<float>(point[axis]);
    const float outside = std::max({lower[axis] - value, 0.0f, value - upper[axis]});
    square += outside * outside;
  }
  return std::sqrt(square);
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
