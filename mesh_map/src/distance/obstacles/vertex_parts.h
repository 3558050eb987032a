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

 private:
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
  std::vector<std::size_t> begins_;  // of the parts, in order_, and its end
};

}  // namespace mesh_map
