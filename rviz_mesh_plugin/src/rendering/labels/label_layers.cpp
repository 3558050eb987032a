#include "rendering/labels/label_layers.h"

#include <algorithm>
#include <utility>

namespace rviz_mesh_plugin {

void LabelLayers::start(std::size_t face_count, Labels labels)
{
  labels_ = std::move(labels);
  above_.assign(face_count, 0);
  label_ = 0;
  next_ = 0;
  layer_ = 0;
  found_ = false;
}

std::size_t LabelLayers::work(std::size_t limit, const Place& place)
{
  std::size_t looked = 0;
  while (!isDone() && looked < limit) {
    const LabelCluster& label = *labels_[label_];
    looked += look(label, limit - looked) + 1;
    if (next_ < label.faces.size()) {
      continue;
    }
    next_ = 0;
    if (!found_) {
      layer_ = std::min<unsigned short>(layer_, COUNT - 1);
      found_ = true;
      place(label, layer_);
      continue;
    }
    found_ = false;
    layer_ = 0;
    if (++label_ == labels_.size()) {
      labels_.clear();
    }
  }
  return looked;
}

std::size_t LabelLayers::look(const LabelCluster& label, std::size_t limit)
{
  const std::size_t begin = next_;
  const std::size_t end = std::min(label.faces.size(), begin + limit);
  const auto next = static_cast<std::uint8_t>(std::min<unsigned short>(layer_ + 1, COUNT - 1));
  for (; next_ < end; ++next_) {
    std::uint8_t& above = above_[label.faces[next_]];
    if (found_) {
      above = next;
    } else {
      layer_ = std::max<unsigned short>(layer_, above);
    }
  }
  return end - begin;
}

}  // namespace rviz_mesh_plugin
