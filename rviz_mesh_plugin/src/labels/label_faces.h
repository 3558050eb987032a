#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Puts faces in ascending order, each once. Takes long for many: not for the GUI thread.
inline void sortFaces(std::vector<std::uint32_t>& faces)
{
  if (!std::is_sorted(faces.begin(), faces.end())) {
    std::sort(faces.begin(), faces.end());
  }
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
}

/// A label without the faces that a mesh of so many does not have; the same one where it has all.
inline LabelClusterConstPtr withinMesh(const LabelClusterConstPtr& label, std::size_t face_count)
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
