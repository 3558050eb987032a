#pragma once

#include <cstdint>
#include <vector>

#include "base/mesh_data.h"

namespace rviz {
class DisplayGroup;
}

namespace rviz_mesh_plugin {

/// The labels that a face has, of those that enabled ClusterLabel displays in this group (and
/// groups in it) show of the mesh.
std::vector<LabelClusterConstPtr> labelsAt(const rviz::DisplayGroup* displays, const MeshData& mesh,
                                           std::uint32_t face);

/// The one of them with the fewest faces; null where there is none.
LabelClusterConstPtr labelAt(const rviz::DisplayGroup* displays, const MeshData& mesh,
                             std::uint32_t face);

}  // namespace rviz_mesh_plugin
