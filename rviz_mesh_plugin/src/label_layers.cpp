#include "rviz_mesh_plugin/label_layers.h"

#include <algorithm>
#include <limits>

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint8_t MANY = std::numeric_limits<std::uint8_t>::max();

}  // namespace

void LabelLayers::reset(std::size_t face_count)
{
  counts_.assign(face_count, 0);
  counts_.shrink_to_fit();
  overlapping_ = 0;
}

void LabelLayers::add(const Faces& faces)
{
  for (const std::uint32_t face : faces) {
    std::uint8_t& count = counts_[face];
    if (count < MANY) {
      ++count;
      overlapping_ += count == 2 ? 1 : 0;
    }
  }
}

void LabelLayers::remove(const Faces& faces)
{
  for (const std::uint32_t face : faces) {
    std::uint8_t& count = counts_[face];
    if (count < MANY) {
      overlapping_ -= count == 2 ? 1 : 0;
      --count;
    }
  }
}

std::vector<unsigned short> LabelLayers::layers(const std::vector<const Faces*>& labels) const
{
  std::vector<unsigned short> result;
  if (!overlap()) {
    result.assign(labels.size(), 0);
    return result;
  }
  std::vector<std::uint8_t> above(counts_.size(), 0);  // the first free layer over each face
  result.reserve(labels.size());
  for (const Faces* faces : labels) {
    unsigned short layer = 0;
    for (const std::uint32_t face : *faces) {
      layer = std::max<unsigned short>(layer, above[face]);
    }
    result.push_back(std::min<unsigned short>(layer, COUNT - 1));
    const auto next = static_cast<std::uint8_t>(std::min<unsigned short>(layer + 1, COUNT - 1));
    for (const std::uint32_t face : *faces) {
      above[face] = next;
    }
  }
  return result;
}

}  // namespace rviz_mesh_plugin
