#include "labels/label_faces.h"

#include <algorithm>
#include <memory>

namespace rviz_mesh_plugin {

void sortFaces(std::vector<std::uint32_t>& faces)
{
  if (!std::is_sorted(faces.begin(), faces.end())) {
    std::sort(faces.begin(), faces.end());
  }
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
}

LabelClusterConstPtr withinMesh(const LabelClusterConstPtr& label, std::size_t face_count)
{
  const std::vector<std::uint32_t>& faces = label->faces;
  if (faces.empty() || faces.back() < face_count) {
    return label;
  }
  auto inside = std::make_shared<LabelCluster>();
  inside->label = label->label;
  inside->faces.assign(faces.begin(), std::lower_bound(faces.begin(), faces.end(), face_count));
  return inside;
}

}  // namespace rviz_mesh_plugin
