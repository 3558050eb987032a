#pragma once

#include <string>

#include "coloring/cost_coloring.h"

namespace rviz_mesh_plugin {

class MeshStore;

/// How a layer is colored on all meshes shown, so that one legend tells of all
/// of them: automatic limits span the costs of all, and are given as custom
/// ones.
CostColoring commonColoring(const MeshStore& store, const std::string& layer,
                            CostColoring coloring);

}  // namespace rviz_mesh_plugin
