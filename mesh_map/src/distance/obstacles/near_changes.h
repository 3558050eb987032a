#pragma once

#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "distance/obstacles/vertex_parts.h"

namespace mesh_map {

/// Straight-line distances of vertices from where an obstacle has changed: lower bounds of those
/// along the surface.
class NearChanges
{
 public:
  /// `changed` vertices (ascending) have become lethal or ceased to be; `lethal` (one byte per
  /// vertex) are those that are now. Edges between what is or was lethal have changed, too. Farther
  /// than `reach` (meters, finite) is infinitely far.
  NearChanges(const FastMarchingMesh& mesh, const std::vector<std::uint32_t>& changed,
              const std::vector<std::uint8_t>& lethal, double reach);

  /// Up to half of the reach it may be any that is not above that.
  double distance(std::uint32_t v) const;

  /// May the part have vertices, or edges of this length of these, within reach of any change?
  bool isNear(const VertexParts& parts, std::size_t part, double edge) const
  {
    return parts.isNear(part, all_.lowest, all_.highest, reach_ + edge);
  }
  /// The same of vertices in a box.
  bool isNear(const VertexBox& box, double edge) const
  {
    const double squared = (reach_ + edge) * (reach_ + edge);
    return std::any_of(regions_.begin(), regions_.end(), [&](const VertexBox& region) {
      return region.squaredDistance(box) <= squared;
    });
  }

 private:
  using Corner = std::array<float, 3>;

  static Corner cornerOf(const PackedPosition& p) { return {p.x, p.y, p.z}; }
  void findRegions(const std::unordered_map<std::uint64_t, VertexBox>& boxes);
  static std::uint64_t cell(const Corner& p, double size, int dx = 0, int dy = 0, int dz = 0);

  const FastMarchingMesh& mesh_;
  double reach_, cell_size_;
  VertexBox all_;
  std::vector<VertexBox> regions_;                                  // few, in which all is
  std::unordered_map<std::uint64_t, std::vector<VertexBox>> near_;  // per cell: those within reach
};

}  // namespace mesh_map
