#include <mesh_map/height_difference.h>
#include <mesh_map/neighborhood.h>
#include <mesh_map/parallel.h>

#include <algorithm>

namespace mesh_map {

std::vector<float> heightDifference(ArrayView<float> positions, const RowsView& neighbors,
                                    double radius, unsigned threads)
{
  constexpr std::size_t vertices_per_chunk = 4096;
  const std::vector<PackedPosition> packed = packPositions(positions);
  std::vector<float> differences(packed.size());
  parallelFor(packed.size(), vertices_per_chunk, threads, [&]() -> RangeBody {
    return [neighborhood = RadiusNeighborhood(packed, neighbors), radius, vertices = packed.data(),
            out = differences.data()](std::size_t begin, std::size_t end) mutable {
      for (std::size_t v = begin; v < end; ++v) {
        float lowest = vertices[v].z, highest = lowest;
        for (const std::uint32_t u : neighborhood.find(static_cast<std::uint32_t>(v), radius)) {
          lowest = std::min(lowest, vertices[u].z);
          highest = std::max(highest, vertices[u].z);
        }
        out[v] = highest - lowest;
      }
    };
  });
  return differences;
}

}  // namespace mesh_map
