#include <mesh_map/height_difference.h>
#include <mesh_map/neighborhood.h>
#include <mesh_map/parallel.h>

#include <algorithm>

namespace mesh_map {

std::vector<PackedPosition> packPositions(ArrayView<float> positions)
{
  std::vector<PackedPosition> packed(positions.size() / 3);
  for (std::size_t v = 0; v < packed.size(); ++v) {
    packed[v] = {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2], 0.0f};
  }
  return packed;
}

std::vector<float> heightDifference(ArrayView<float> positions, const RowsView& neighbors,
                                    double radius, unsigned threads)
{
  constexpr std::size_t vertices_per_chunk = 4096;
  const std::vector<PackedPosition> packed = packPositions(positions);
  std::vector<float> differences(packed.size());
  parallelFor(packed.size(), vertices_per_chunk, threads, [&]() -> RangeBody {
    return [neighborhood = RadiusNeighborhood(packed, neighbors), radius, center = packed.data(),
            out = differences.data()](std::size_t begin, std::size_t end) mutable {
      for (std::size_t v = begin; v < end; ++v) {
        float lowest = center[v].z, highest = center[v].z;
        neighborhood.visit(static_cast<std::uint32_t>(v), radius,
                           [&](std::uint32_t, const PackedPosition& position) {
                             lowest = std::min(lowest, position.z);
                             highest = std::max(highest, position.z);
                           });
        out[v] = highest - lowest;
      }
    };
  });
  return differences;
}

}  // namespace mesh_map
