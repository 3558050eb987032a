#pragma once

#include <cstdint>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz {
class DisplayGroup;
}

namespace rviz_mesh_plugin {

/// The label that a face has, of those that ClusterLabel displays in this group (and groups in it)
/// show of the mesh; null where it has none. Of several, it is the one with the fewest faces.
LabelClusterConstPtr labelAt(const rviz::DisplayGroup* displays, const MeshData& mesh,
                             std::uint32_t face);

}  // namespace rviz_mesh_plugin
