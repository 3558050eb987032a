#include "rviz_mesh_plugin/label_lookup.h"

#include <algorithm>

#include <rviz/display_group.h>

#include "rviz_mesh_plugin/cluster_label_display.h"

namespace rviz_mesh_plugin {
namespace {

void takeSmaller(LabelClusterConstPtr& best, const LabelClusterConstPtr& other)
{
  if (other && (!best || other->faces.size() < best->faces.size())) {
    best = other;
  }
}

}  // namespace

LabelClusterConstPtr labelAt(const rviz::DisplayGroup* displays, const MeshData& mesh,
                             std::uint32_t face)
{
  LabelClusterConstPtr best;
  for (int i = 0; displays && i < displays->numDisplays(); ++i) {
    const rviz::Display* display = displays->getDisplayAt(i);
    const auto* labels = dynamic_cast<const ClusterLabelDisplay*>(display);
    const MeshDataConstPtr labelled = labels && labels->isEnabled() ? labels->mesh() : nullptr;
    // Displays that have received the same mesh share it; else its name tells.
    if (labelled && (labelled.get() == &mesh ||
                     (labelled->uuid == mesh.uuid && labelled->faceCount() == mesh.faceCount()))) {
      for (const auto& entry : labels->labels()) {
        const auto& faces = entry.second->faces;
        if (std::binary_search(faces.begin(), faces.end(), face)) {
          takeSmaller(best, entry.second);
        }
      }
    }
    takeSmaller(best, labelAt(dynamic_cast<const rviz::DisplayGroup*>(display), mesh, face));
  }
  return best;
}

}  // namespace rviz_mesh_plugin
