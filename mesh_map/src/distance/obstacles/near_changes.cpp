#include "distance/obstacles/near_changes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

/// What lies as close together as this part of the reach is one box.
constexpr double BOX_SIZE = 0.125;

}  // namespace

void NearChanges::Box::add(const Box& other)
{
  for (unsigned axis = 0; axis < 3; ++axis) {
    lowest[axis] = std::min(lowest[axis], other.lowest[axis]);
    highest[axis] = std::max(highest[axis], other.highest[axis]);
  }
}

double NearChanges::Box::squaredDistance(const PackedPosition& p) const
{
  const Corner place = cornerOf(p);
  double sum = 0.0;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double gap =
        std::max({0.0, double{lowest[axis]} - place[axis], double{place[axis]} - highest[axis]});
    sum += gap * gap;
  }
  return sum;
}

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
  std::unordered_map<std::uint64_t, Box> boxes;
  for (const std::uint32_t v : changed) {
    const Corner place = cornerOf(mesh.position(v));
    Box box{place, place};
    for (const FastMarchingCorner& corner : mesh.corners(v)) {
      for (const std::uint32_t u : {corner.a, corner.b}) {
        if (lethal[u] != 0) {
          const Corner other = cornerOf(mesh.position(u));
          box.add({other, other});
        }
      }
    }
    boxes.emplace(cell(place, BOX_SIZE * reach), box).first->second.add(box);
    all_.add(box);
  }
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

double NearChanges::distance(std::uint32_t v) const
{
  const PackedPosition& p = mesh_.position(v);
  double squared = std::numeric_limits<double>::infinity();
  if (all_.squaredDistance(p) <= reach_ * reach_) {
    const auto found = near_.find(cell(cornerOf(p), cell_size_));
    if (found != near_.end()) {
      for (const Box& box : found->second) {
        squared = std::min(squared, box.squaredDistance(p));
      }
    }
  }
  return squared <= reach_ * reach_ ? std::sqrt(squared) : std::numeric_limits<double>::infinity();
}

}  // namespace mesh_map
