#pragma once

#include <optional>
#include <vector>

#include "picking/surface_picker.h"
#include "selection/selection_gestures.h"
#include "tools/selection/selection_properties.h"

namespace Ogre {
class Viewport;
}

namespace rviz_mesh_plugin {

/// Where the brush touches surfaces between two places of the cursor.
struct BrushPath
{
  std::vector<SurfaceHit> hits;    ///< in the order of the path
  std::optional<SurfaceHit> last;  ///< under the cursor; none where no surface is there
};

/// Follows the cursor on its straight way in the picture from one event to the next, however far
/// apart they are. Hits lie at most half a radius apart on the surface, and cover as little of the
/// picture as that is there, so that nothing between them is left out; but where the surface has a
/// gap or ends, nothing is added that is not under the way. Where that would take too many, they
/// are spread evenly over the way.
/// @param before what was under the cursor at the beginning, which is not among the hits
BrushPath followBrush(const SurfacePicker& picker, const Ogre::Viewport& viewport,
                      const Gesture& gesture, std::optional<SurfaceHit> before,
                      const SelectionSettings& settings);

}  // namespace rviz_mesh_plugin
