#include "labels/given_faces.h"

#include <algorithm>

namespace rviz_mesh_plugin {

LabelFacesConstPtr GivenFaces::sorted() const
{
  if (bits_) {
    return labelFaces(bits_->faces());
  }
  const auto isOutOfOrder = [](std::uint32_t face, std::uint32_t next) { return face >= next; };
  if (std::adjacent_find(list_->begin(), list_->end(), isOutOfOrder) == list_->end()) {
    return list_;
  }
  Faces sorted = *list_;
  sortFaces(sorted);
  return labelFaces(std::move(sorted));
}

}  // namespace rviz_mesh_plugin
