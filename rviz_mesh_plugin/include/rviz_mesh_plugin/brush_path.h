#pragma once

#include <optional>
#include <vector>

#include "rviz_mesh_plugin/selection_gestures.h"
#include "rviz_mesh_plugin/selection_properties.h"
#include "rviz_mesh_plugin/surface_picker.h"

namespace rviz_mesh_plugin {

struct BrushPath
{
  std::vector<SurfaceHit> hits;
  std::optional<SurfaceHit> last;  ///< under the cursor; none where no surface is there
};

/// Where the brush touches surfaces on the way of the cursor from one event to the next: so often
/// that it leaves no gaps, on the surface and in the picture.
/// @param before what was under the cursor at the beginning, which is not among the hits
BrushPath followBrush(const SurfacePicker& picker, const rviz::ViewportMouseEvent& event,
                      const Gesture& gesture, std::optional<SurfaceHit> before,
                      const SelectionSettings& settings);

}  // namespace rviz_mesh_plugin
