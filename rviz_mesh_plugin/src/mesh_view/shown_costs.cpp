#include "mesh_view/shown_costs.h"

#include <algorithm>
#include <optional>

#include "incoming/mesh_store.h"

namespace rviz_mesh_plugin {

CostColoring commonColoring(const MeshStore& store, const std::string& layer, CostColoring coloring)
{
  if (coloring.custom_limits) {
    return coloring;
  }
  std::optional<CostLimits> common;
  for (const MeshDataConstPtr& mesh : store.meshes()) {
    const CostLayerConstPtr costs = store.attributes(mesh->uuid).cost(layer);
    if (!costs || costs->summary.finite == 0) {
      continue;
    }
    const CostLimits limits = limitsOf(coloring, costs->summary);
    common = common ? CostLimits{std::min(common->lower, limits.lower),
                                 std::max(common->upper, limits.upper)}
                    : limits;
  }
  if (common) {
    coloring.custom_limits = true;
    coloring.limits = *common;
  }
  return coloring;
}

}  // namespace rviz_mesh_plugin
