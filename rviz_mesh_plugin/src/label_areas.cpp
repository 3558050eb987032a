#include "rviz_mesh_plugin/label_areas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t SLICE = 4096;  // faces between two looks at the clock

double areaOf(const MeshData& mesh, std::uint32_t face)
{
  const auto corner = [&](std::size_t i) -> const std::array<float, 3>& {
    return mesh.vertices[mesh.indices[3 * std::size_t{face} + i]].position;
  };
  std::array<double, 3> u{};
  std::array<double, 3> v{};
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = double{corner(1)[i]} - corner(0)[i];
    v[i] = double{corner(2)[i]} - corner(0)[i];
  }
  return 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                          u[0] * v[1] - u[1] * v[0]);
}

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
        sum.area += areaOf(*mesh, faces[sum.next++]);
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
