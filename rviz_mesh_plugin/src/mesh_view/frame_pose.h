#pragma once

#include <optional>
#include <string>

#include "base/status_lines.h"
#include "rendering/placed_visual.h"

namespace rviz {
class FrameManager;
}

namespace rviz_mesh_plugin {

/// The pose of a frame by its newest transform: a mesh is a map, its stamp tells when it was made.
/// @param what lies in it, and is hidden while the transform is not known: "the mesh is"
/// @param line says how it went
std::optional<FramePose> findPose(rviz::FrameManager& frames, const std::string& frame,
                                  const std::string& what, StatusLine& line);

}  // namespace rviz_mesh_plugin
