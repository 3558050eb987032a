#pragma once

#include <algorithm>
#include <cstddef>

#include <OgreAxisAlignedBox.h>

#include "base/bounds.h"
#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {

/// OGRE squares and adds coordinates of bounds: farther out they are cut, so that nothing
/// overflows.
constexpr float FARTHEST_BOUND = 1e15f;

/// @param margin added on all sides
inline Ogre::AxisAlignedBox finiteBounds(const Bounds& bounds, float margin = 0.0f)
{
  Ogre::Vector3 corners[2];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    corners[0][axis] = std::clamp(bounds.lower[axis] - margin, -FARTHEST_BOUND, FARTHEST_BOUND);
    corners[1][axis] = std::clamp(bounds.upper[axis] + margin, -FARTHEST_BOUND, FARTHEST_BOUND);
  }
  return Ogre::AxisAlignedBox(corners[0], corners[1]);
}

/// Of a sphere about the origin of the node that holds the box, as OGRE uses it.
inline Ogre::Real radiusAboutOrigin(const Ogre::AxisAlignedBox& box)
{
  const Ogre::Vector3& lower = box.getMinimum();
  const Ogre::Vector3& upper = box.getMaximum();
  return Ogre::Vector3(std::max(-lower.x, upper.x), std::max(-lower.y, upper.y),
                       std::max(-lower.z, upper.z))
      .length();
}

}  // namespace rviz_mesh_plugin
