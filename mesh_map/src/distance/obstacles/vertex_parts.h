#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "distance/obstacles/window_propagation.h"

namespace mesh_map {

/// An axis-parallel box.
struct VertexBox
{
  std::array<float, 3> lowest, highest;

  void add(const VertexBox& other)
  {
    for (unsigned axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], other.lowest[axis]);
      highest[axis] = std::max(highest[axis], other.highest[axis]);
    }
  }

  /// Squared, of what is nearest to each other.
  double squaredDistance(const VertexBox& other) const
  {
    double sum = 0.0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const double gap = std::max({0.0, double{lowest[axis]} - other.highest[axis],
                                   double{other.lowest[axis]} - highest[axis]});
      sum += gap * gap;
    }
    return sum;
  }
};

/// The vertices of a mesh in slabs across its longest axis, each small enough for caches.
class VertexParts
{
 public:
  /// No more slabs than `width` (meters, may be infinite) fits into the mesh, which has to outlive
  /// this object.
  VertexParts(const FastMarchingMesh& mesh, double width);

  std::size_t size() const { return cuts_.size() + 1; }

  std::size_t partOf(std::uint32_t v) const
  {
    return std::upper_bound(cuts_.begin(), cuts_.end(), coordinate(v)) - cuts_.begin();
  }

  bool isIn(std::uint32_t v, std::size_t part) const
  {
    const float at = coordinate(v);
    return (part == 0 || at >= cuts_[part - 1]) && (part == cuts_.size() || at < cuts_[part]);
  }

  WindowScope scope(std::size_t part) const
  {
    WindowScope result;
    result.axis = axis_;
    result.low = part > 0 ? double{cuts_[part - 1]} : result.low;
    result.high = part < cuts_.size() ? double{cuts_[part]} : result.high;
    return result;
  }

  bool isVertexNear(std::uint32_t v, std::size_t part, double distance) const
  {
    const WindowScope to = scope(part);
    const double at = coordinate(v);
    return at >= to.low - distance && at <= to.high + distance;
  }
  /// May it have vertices within a distance of those of another part?
  bool isNear(std::size_t part, std::size_t other, double distance) const
  {
    const WindowScope to = scope(other);
    return isNear(part, to.low - distance, to.high + distance);
  }
  /// ... or of a box?
  bool isNear(std::size_t part, const std::array<float, 3>& lowest,
              const std::array<float, 3>& highest, double distance) const
  {
    return isNear(part, lowest[axis_] - distance, highest[axis_] + distance);
  }

  /// Sorts the vertices into their parts, once. One call at a time.
  void sort();
  /// Ascending; after sort().
  ArrayView<std::uint32_t> vertices(std::size_t part) const
  {
    return {order_.data() + begins_[part], begins_[part + 1] - begins_[part]};
  }
  /// Calls visit(box, vertices) for all of a part, in blocks of what comes after each other; after
  /// sort().
  template <class Visit>
  void forEachBlock(std::size_t part, const Visit& visit) const
  {
    const VertexBox* box = boxes_.data() + first_boxes_[part];
    for (std::size_t begin = begins_[part]; begin < begins_[part + 1]; begin += BLOCK) {
      const std::size_t end = std::min(begin + BLOCK, begins_[part + 1]);
      visit(*box++, ArrayView<std::uint32_t>{order_.data() + begin, end - begin});
    }
  }

 private:
  /// Vertices whose box is looked at before them.
  static constexpr std::size_t BLOCK = 64;

  void findBoxes();
  float coordinate(std::uint32_t v) const
  {
    const PackedPosition& p = mesh_.position(v);
    return axis_ == 0 ? p.x : axis_ == 1 ? p.y : p.z;
  }

  bool isNear(std::size_t part, double low, double high) const
  {
    const WindowScope own = scope(part);
    return own.low <= high && own.high >= low;
  }

  const FastMarchingMesh& mesh_;
  unsigned axis_ = 0;
  std::vector<float> cuts_;  // between parts, ascending: each belongs to the part above it
  LargeArray<std::uint32_t> order_;
  bool is_sorted_ = false;
  std::vector<std::size_t> begins_;       // of the parts, in order_, and its end
  std::vector<VertexBox> boxes_;          // of the blocks
  std::vector<std::size_t> first_boxes_;  // of the parts
};

}  // namespace mesh_map
