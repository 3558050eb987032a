#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

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

  /// The longest one.
  unsigned axis() const { return axis_; }

  /// May it have vertices within a distance of a box?
  bool isNear(std::size_t part, const std::array<float, 3>& lowest,
              const std::array<float, 3>& highest, double distance) const
  {
    return (part == 0 || cuts_[part - 1] <= highest[axis_] + distance) &&
           (part == cuts_.size() || cuts_[part] >= lowest[axis_] - distance);
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
