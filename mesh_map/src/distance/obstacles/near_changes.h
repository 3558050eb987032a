#pragma once

#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

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
  /// `changed` vertices have become lethal or ceased to be; `lethal` (one byte per vertex) are all
  /// that are or were: edges to these have changed, too. Farther than `reach` (meters, finite) is
  /// infinitely far.
  NearChanges(const FastMarchingMesh& mesh, const std::vector<std::uint32_t>& changed,
              const std::vector<std::uint8_t>& lethal, double reach);

  double distance(std::uint32_t v) const;

  /// May the part have vertices, or edges of this length of these, within reach of any change?
  bool isNear(const VertexParts& parts, std::size_t part, double edge) const
  {
    return parts.isNear(part, all_.lowest, all_.highest, reach_ + edge);
  }

 private:
  using Corner = std::array<float, 3>;

  struct Box
  {
    Corner lowest, highest;

    void add(const Box& other);
    double squaredDistance(const PackedPosition& p) const;
  };

  static Corner cornerOf(const PackedPosition& p) { return {p.x, p.y, p.z}; }
  static std::uint64_t cell(const Corner& p, double size, int dx = 0, int dy = 0, int dz = 0);

  const FastMarchingMesh& mesh_;
  double reach_, cell_size_;
  Box all_;
  std::unordered_map<std::uint64_t, std::vector<Box>> near_;  // per cell: those within its reach
};

}  // namespace mesh_map
