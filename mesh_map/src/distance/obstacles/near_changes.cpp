#include "distance/obstacles/near_changes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

/// What lies as close together as this part of the reach is one box.
constexpr double BOX_SIZE = 0.125;

/// There are no more regions than this.
constexpr std::size_t MOST_REGIONS = 64;

}  // namespace

/// A number of the cell of a point, or of one beside it. Different cells may share one, which costs
/// a little time.
std::uint64_t NearChanges::cell(const Corner& p, double size, int dx, int dy, int dz)
{
  const auto number = [size](float value, int step) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value / size)) + step) &
           0x1fffff;
  };
  return number(p[0], dx) << 42 | number(p[1], dy) << 21 | number(p[2], dz);
}

NearChanges::NearChanges(const FastMarchingMesh& mesh, const std::vector<std::uint32_t>& changed,
                         const std::vector<std::uint8_t>& lethal, double reach)
    : mesh_(mesh),
      reach_(reach),
      all_{{INFINITE, INFINITE, INFINITE}, {-INFINITE, -INFINITE, -INFINITE}}
{
  const auto isEver = [&](std::uint32_t v) {
    return lethal[v] != 0 || std::binary_search(changed.begin(), changed.end(), v);
  };
  std::unordered_map<std::uint64_t, VertexBox> boxes;
  for (const std::uint32_t v : changed) {
    const Corner place = cornerOf(mesh.position(v));
    VertexBox box{place, place};
    for (const FastMarchingCorner& corner : mesh.corners(v)) {
      for (const std::uint32_t u : {corner.a, corner.b}) {
        if (isEver(u)) {
          const Corner other = cornerOf(mesh.position(u));
          box.add({other, other});
        }
      }
    }
    boxes.emplace(cell(place, BOX_SIZE * reach), box).first->second.add(box);
    all_.add(box);
  }
  findRegions(boxes);
  double widest = 0.0;
  for (const auto& entry : boxes) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      widest = std::max(widest, double{entry.second.highest[axis]} - entry.second.lowest[axis]);
    }
  }
  cell_size_ = reach + widest;
  for (const auto& entry : boxes) {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -1; dz <= 1; ++dz) {
          near_[cell(entry.second.lowest, cell_size_, dx, dy, dz)].push_back(entry.second);
        }
      }
    }
  }
}

/// What lies in one cell is one region; cells are as large as it takes for few of them.
void NearChanges::findRegions(const std::unordered_map<std::uint64_t, VertexBox>& boxes)
{
  std::unordered_map<std::uint64_t, VertexBox> regions;
  for (double size = reach_; regions.empty() || regions.size() > MOST_REGIONS; size *= 2.0) {
    regions.clear();
    for (const auto& entry : boxes) {
      regions.emplace(cell(entry.second.lowest, size), entry.second)
          .first->second.add(entry.second);
    }
  }
  for (const auto& entry : regions) {
    regions_.push_back(entry.second);
  }
}

double NearChanges::distance(std::uint32_t v) const
{
  const Corner p = cornerOf(mesh_.position(v));
  const VertexBox place{p, p};
  double squared = std::numeric_limits<double>::infinity();
  if (all_.squaredDistance(place) <= reach_ * reach_) {
    const auto found = near_.find(cell(p, cell_size_));
    if (found != near_.end()) {
      const double enough = 0.25 * reach_ * reach_;
      for (auto box = found->second.begin(); box != found->second.end() && squared > enough;
           ++box) {
        squared = std::min(squared, box->squaredDistance(place));
      }
    }
  }
  return squared <= reach_ * reach_ ? std::sqrt(squared) : std::numeric_limits<double>::infinity();
}

}  // namespace mesh_map
