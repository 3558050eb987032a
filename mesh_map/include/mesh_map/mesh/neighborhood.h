#pragma once

#include <mesh_map/base/array_view.h>

#include <cstdint>
#include <vector>

namespace mesh_map {

/// A vertex position in one 16-byte slot, so that reading it touches one cache line.
struct alignas(16) PackedPosition
{
  float x, y, z, unused;
};

std::vector<PackedPosition> packPositions(ArrayView<float> positions);

/// Finds the connected neighborhood N_r(v): the vertices reached from v over edges, growing only
/// through vertices whose Euclidean distance from v (in double precision) is below r. Owns scratch
/// memory: one per thread.
class RadiusNeighborhood
{
 public:
  /// The arrays have to outlive this object.
  RadiusNeighborhood(const std::vector<PackedPosition>& positions, const RowsView& neighbors);

  /// v itself, first, and the vertices of N_r(v), each once. Valid until the next call.
  ArrayView<std::uint32_t> find(std::uint32_t v, double radius);

 private:
  const PackedPosition* positions_;
  const std::uint32_t* offsets_;
  const std::uint32_t* neighbors_;
  std::vector<std::uint32_t> stamps_;  // the last center that looked at this vertex
  std::vector<std::uint32_t> found_;
};

}  // namespace mesh_map
