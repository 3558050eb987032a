#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

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
  /// No more slabs than `width` (meters, may be infinite) fits into the mesh.
  VertexParts(const FastMarchingMesh& mesh, double width, unsigned threads);

  std::size_t size() const { return parts_.size(); }
  /// Ascending.
  ArrayView<std::uint32_t> vertices(std::size_t part) const
  {
    return {order_.data() + parts_[part].begin, parts_[part].end - parts_[part].begin};
  }

  WindowScope scope(std::size_t part) const
  {
    WindowScope result;
    if (parts_.size() > 1) {
      result.axis = axis_;
      result.low = parts_[part].low;
      result.high = parts_[part].high;
    }
    return result;
  }
  /// Has it vertices, or edges of these, within a distance of another part?
  bool isNear(std::size_t part, std::size_t other, double distance) const
  {
    return isNear(part, parts_[other].low - distance, parts_[other].high + distance);
  }
  /// ... or of a box?
  bool isNear(std::size_t part, const std::array<float, 3>& lowest,
              const std::array<float, 3>& highest, double distance) const
  {
    return isNear(part, lowest[axis_] - distance, highest[axis_] + distance);
  }

 private:
  struct Part
  {
    std::size_t begin, end;       // in order_
    float low, high;              // of the vertices
    float edges_low, edges_high;  // of all edges of these
  };

  float coordinate(const PackedPosition& p) const
  {
    return axis_ == 0 ? p.x : axis_ == 1 ? p.y : p.z;
  }

  bool isNear(std::size_t part, double low, double high) const
  {
    return parts_[part].edges_low <= high && parts_[part].edges_high >= low;
  }

  unsigned axis_ = 0;
  LargeArray<std::uint32_t> order_;
  std::vector<Part> parts_;
};

}  // namespace mesh_map
