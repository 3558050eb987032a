#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "base/vector3.h"

namespace mesh_map {

/// Along the axes; of nothing: empty.
struct Box
{
  Vector3 low = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                 std::numeric_limits<double>::infinity()};
  Vector3 high = -low;

  void add(const Vector3& point)
  {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], point[k]);
      high[k] = std::max(high[k], point[k]);
    }
  }

  bool meets(const Box& other) const
  {
    for (std::size_t k = 0; k < 3; ++k) {
      if (low[k] > other.high[k] || high[k] < other.low[k]) {
        return false;
      }
    }
    return true;
  }

  double diagonal() const { return high[0] < low[0] ? 0.0 : distance(low, high); }
};

/// Boxes by the cells of a grid that they are in; those that are in very many are kept apart.
class BoxGrid
{
 public:
  explicit BoxGrid(const std::vector<Box>& boxes) : boxes_(boxes)
  {
    std::vector<double> sizes;
    for (const Box& box : boxes) {
      sizes.push_back(box.diagonal());
    }
    if (!sizes.empty()) {
      std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(sizes.size() / 2),
                       sizes.end());
      cell_ = std::max(2.0 * sizes[sizes.size() / 2], 1e-6);
    }
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      if (!visitCells(boxes[i], [&](std::uint64_t cell) { cells_[cell].push_back(i); })) {
        large_.push_back(i);
      }
    }
  }

  /// visit(i) for each box that meets this one, some more than once.
  template <class Visit>
  void visitMeeting(const Box& box, const Visit& visit) const
  {
    const auto visitIf = [&](std::uint32_t i) {
      if (boxes_[i].meets(box)) {
        visit(i);
      }
    };
    for (const std::uint32_t i : large_) {
      visitIf(i);
    }
    const bool few = visitCells(box, [&](std::uint64_t cell) {
      const auto found = cells_.find(cell);
      if (found != cells_.end()) {
        std::for_each(found->second.begin(), found->second.end(), visitIf);
      }
    });
    for (std::uint32_t i = 0; !few && i < boxes_.size(); ++i) {
      visitIf(i);
    }
  }

 private:
  /// visit(cell) for the cells of a box; false, and nothing visited, where they are too many.
  template <class Visit>
  bool visitCells(const Box& box, const Visit& visit) const
  {
    constexpr double most = 64.0;
    std::array<std::int64_t, 3> low, high;
    double count = 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double first = std::floor(box.low[k] / cell_), last = std::floor(box.high[k] / cell_);
      count *= last - first + 1.0;
      if (!(count <= most) || std::abs(first) > 1e15 || std::abs(last) > 1e15) {
        return false;
      }
      low[k] = static_cast<std::int64_t>(first);
      high[k] = static_cast<std::int64_t>(last);
    }
    for (std::int64_t x = low[0]; x <= high[0]; ++x) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          // Cells that share a number only cost a comparison of boxes.
          visit(static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15u ^
                static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4Fu ^
                static_cast<std::uint64_t>(z) * 0x165667B19E3779F9u);
        }
      }
    }
    return true;
  }

  const std::vector<Box>& boxes_;
  double cell_ = 1.0;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
  std::vector<std::uint32_t> large_;
};

}  // namespace mesh_map
