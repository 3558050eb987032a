#pragma once

#include <cstddef>
#include <vector>

#include "rviz_mesh_plugin/layout_split.h"

namespace rviz_mesh_plugin {

/// A part has at most this many faces.
constexpr std::size_t PART_FACES = 8192;

/// Cuts faces that are ordered in space into parts of one material that have small boxes: gives the
/// first face of each part, and the end.
std::vector<std::size_t> cutIntoParts(const SplitFaces& faces,
                                      const std::vector<MeshVertex>& vertices);

}  // namespace rviz_mesh_plugin
