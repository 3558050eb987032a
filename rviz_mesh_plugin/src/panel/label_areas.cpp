#include "panel/label_areas.h"

#include <algorithm>
#include <iterator>

#include "selection/selection_regions.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t SLICE = 4096;  // faces between two looks at the clock

}  // namespace

bool LabelAreas::work(const MeshDataConstPtr& mesh, const LabelClusters& labels,
                      std::chrono::microseconds budget)
{
  if (mesh != mesh_) {
    sums_.clear();
    mesh_ = mesh;
  }
  for (auto sum = sums_.begin(); sum != sums_.end();) {
    sum = labels.count(sum->first) == 0 ? sums_.erase(sum) : std::next(sum);
  }
  const auto end = std::chrono::steady_clock::now() + budget;
  for (const auto& label : labels) {
    Sum& sum = sums_[label.first];
    if (sum.label != label.second) {
      sum = Sum{label.second};
    }
    const auto& faces = sum.label->faces;
    while (sum.next < faces.size()) {
      if (!mesh || std::chrono::steady_clock::now() >= end) {
        return false;
      }
      for (const std::size_t last = std::min(sum.next + SLICE, faces.size()); sum.next < last;) {
        sum.area += faceArea(*mesh, faces[sum.next++]);
      }
    }
  }
  return true;
}

std::optional<double> LabelAreas::area(const std::string& label) const
{
  const auto sum = sums_.find(label);
  if (sum == sums_.end() || sum->second.next < sum->second.label->faces.size()) {
    return std::nullopt;
  }
  return sum->second.area;
}

}  // namespace rviz_mesh_plugin
