#ifndef MESH_MAP_NEIGHBORHOOD_H
#define MESH_MAP_NEIGHBORHOOD_H

#include <mesh_map/array_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// A vertex position in one 16-byte slot, so that reading it touches one cache line.
struct alignas(16) PackedPosition
{
  float x, y, z, unused;
};

std::vector<PackedPosition> packPositions(ArrayView<float> positions);

/// Visits the connected neighborhood N_r(v): the vertices reached from v over edges, growing only
/// through vertices whose Euclidean distance from v (in double precision) is below r. Owns scratch
/// memory: one per thread.
class RadiusNeighborhood
{
 public:
  /// The arrays have to outlive this object.
  RadiusNeighborhood(const std::vector<PackedPosition>& positions, const RowsView& neighbors)
      : positions_(positions.data()),
        offsets_(neighbors.offsets.data()),
        neighbors_(neighbors.values.data()),
        stamps_(positions.size(), NO_INDEX)
  {
  }

  /// Calls visit(vertex, position) once for v itself, first, and for every vertex of N_r(v).
  template <class Visitor>
  void visit(std::uint32_t v, double radius, const Visitor& visit)
  {
    const PackedPosition center = positions_[v];
    const double squared_radius = radius * radius;
    front_.clear();
    front_.push_back(v);
    stamps_[v] = v;
    visit(v, center);
    for (std::size_t i = 0; i < front_.size(); ++i) {
      const std::uint32_t from = front_[i];
      for (std::uint32_t k = offsets_[from]; k < offsets_[from + 1]; ++k) {
        const std::uint32_t to = neighbors_[k];
        if (stamps_[to] == v) {
          continue;
        }
        stamps_[to] = v;
        const PackedPosition position = positions_[to];
        const double x = double{position.x} - center.x;
        const double y = double{position.y} - center.y;
        const double z = double{position.z} - center.z;
        if (x * x + y * y + z * z < squared_radius) {
          front_.push_back(to);
          visit(to, position);
        }
      }
    }
  }

 private:
  const PackedPosition* positions_;
  const std::uint32_t* offsets_;
  const std::uint32_t* neighbors_;
  std::vector<std::uint32_t> stamps_;  // the last center that looked at this vertex
  std::vector<std::uint32_t> front_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_NEIGHBORHOOD_H
