#include "picking/label_lookup.h"

#include <algorithm>

#include "displays/cluster_label_display.h"
#include "displays/display_tree.h"

namespace rviz_mesh_plugin {

std::vector<LabelClusterConstPtr> labelsAt(const rviz::DisplayGroup* displays, const MeshData& mesh,
                                           std::uint32_t face)
{
  std::vector<LabelClusterConstPtr> found;
  visitDisplays<ClusterLabelDisplay>(
      displays, DisplayChoice::ENABLED, [&](const ClusterLabelDisplay& display) {
        // Displays that have received the same mesh share it; else its name tells.
        const MeshDataConstPtr labelled = display.mesh();
        if (!labelled || (labelled.get() != &mesh && (labelled->uuid != mesh.uuid ||
                                                      labelled->faceCount() != mesh.faceCount()))) {
          return;
        }
        for (const auto& label : display.labels()) {
          const auto& faces = label.second->faces;
          if (std::binary_search(faces.begin(), faces.end(), face)) {
            found.push_back(label.second);
          }
        }
      });
  return found;
}

LabelClusterConstPtr labelAt(const rviz::DisplayGroup* displays, const MeshData& mesh,
                             std::uint32_t face)
{
  const auto found = labelsAt(displays, mesh, face);
  const auto best = std::min_element(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a->faces.size() < b->faces.size();
  });
  return best == found.end() ? nullptr : *best;
}

}  // namespace rviz_mesh_plugin
