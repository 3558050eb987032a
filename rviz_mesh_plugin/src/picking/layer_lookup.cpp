#include "picking/layer_lookup.h"

#include <algorithm>

#include "displays/display_tree.h"
#include "displays/textured_mesh_display.h"

namespace rviz_mesh_plugin {

std::vector<KnownLayer> layersOf(const rviz::DisplayGroup* displays, const MeshDataConstPtr& mesh)
{
  std::vector<KnownLayer> layers;
  const auto isKnown = [&](const std::string& name) {
    return std::any_of(layers.begin(), layers.end(),
                       [&](const KnownLayer& known) { return known.name == name; });
  };
  visitDisplays<TexturedMeshDisplay>(
      displays, DisplayChoice::ENABLED, [&](const TexturedMeshDisplay& display) {
        if (!display.has(mesh)) {
          return;
        }
        for (const std::string& name : display.costTypes()) {
          const CostLayerConstPtr layer = display.attributes(*mesh).cost(name);
          if (layer && !isKnown(name)) {
            layers.push_back({name, layer, display.layerInfo(*mesh, name)});
          }
        }
      });
  return layers;
}

}  // namespace rviz_mesh_plugin
