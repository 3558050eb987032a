#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The faces of a label: ascending, each once. Shared, since there may be millions.
using LabelFacesConstPtr = std::shared_ptr<const std::vector<std::uint32_t>>;

/// @param faces ascending, each once
inline LabelFacesConstPtr labelFaces(std::vector<std::uint32_t> faces)
{
  return std::make_shared<const std::vector<std::uint32_t>>(std::move(faces));
}

/// None: the label is not there.
inline LabelFacesConstPtr facesOf(const LabelClusters& labels, const std::string& label)
{
  static const LabelFacesConstPtr none = labelFaces({});
  const auto found = labels.find(label);
  return found == labels.end() ? none : LabelFacesConstPtr(found->second, &found->second->faces);
}

/// Puts faces in ascending order, each once. Takes long for many: not for the GUI thread.
inline void sortFaces(std::vector<std::uint32_t>& faces)
{
  if (!std::is_sorted(faces.begin(), faces.end())) {
    std::sort(faces.begin(), faces.end());
  }
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
}

/// The faces of both.
inline LabelFacesConstPtr united(const LabelFacesConstPtr& a, const LabelFacesConstPtr& b)
{
  if (a->empty() || b->empty()) {
    return a->empty() ? b : a;
  }
  std::vector<std::uint32_t> all;
  all.reserve(a->size() + b->size());
  std::set_union(a->begin(), a->end(), b->begin(), b->end(), std::back_inserter(all));
  return labelFaces(std::move(all));
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
