#pragma once

#include <string>
#include <vector>

#include "base/layer_info.h"
#include "base/mesh_data.h"

namespace rviz {
class DisplayGroup;
}

namespace rviz_mesh_plugin {

/// A cost layer of a mesh that has arrived, and what its values mean.
struct KnownLayer
{
  std::string name;  ///< that it is chosen by
  CostLayerConstPtr layer;
  LayerInfo info;
};

/// Those that enabled TexturedMesh displays in this group (and groups in it) have of a mesh, in the
/// order of their first arrival. Of several displays the first one gives the layer.
std::vector<KnownLayer> layersOf(const rviz::DisplayGroup* displays, const MeshDataConstPtr& mesh);

}  // namespace rviz_mesh_plugin
