#ifndef MESH_MAP_SRC_RADIUS_BLOCK_H
#define MESH_MAP_SRC_RADIUS_BLOCK_H

#include <mesh_map/large_array.h>
#include <mesh_map/radius_statistics.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "radius_attributes.h"
#include "radius_grid.h"

namespace mesh_map {

/// All vertices in the order of a grid, so that those of a cell lie side by side.
struct OrderedMesh
{
  RadiusAttributes attributes;
  LargeArray<std::uint32_t> offsets, neighbors;  // places, not indices
};

OrderedMesh inOrderOf(const RadiusGrid& grid, const RadiusQuery& query);

/// Those vertices of a mesh that can be within the radius of any vertex of one cell, side by side
/// in small arrays that stay in the cache, and what edges connect of them.
class Block
{
 public:
  explicit Block(const OrderedMesh& mesh) : mesh_(mesh), local_(mesh.attributes.size(), 0) {}

  void gather(const std::vector<RadiusGrid::Range>& ranges);

  std::size_t size() const { return places_.size(); }
  /// Where a vertex of the block is in the arrays below.
  std::uint32_t localOf(std::uint32_t place) const { return local_[place]; }

  RadiusAttributes attributes;
  std::vector<std::uint32_t> offsets, neighbors;

 private:
  const OrderedMesh& mesh_;
  std::vector<std::uint32_t> local_;  // per place; may be of an earlier block
  std::vector<std::uint32_t> places_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_RADIUS_BLOCK_H
