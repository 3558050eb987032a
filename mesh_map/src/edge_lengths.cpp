#include <mesh_map/parallel.h>
#include <mesh_map/topology.h>

#include <cmath>

namespace mesh_map {

std::vector<float> edgeLengths(ArrayView<float> positions, ArrayView<std::uint32_t> edges,
                               unsigned threads)
{
  constexpr std::size_t edges_per_chunk = 65536;
  std::vector<float> lengths(edges.size() / 2);
  parallelFor(lengths.size(), edges_per_chunk, threads, [&]() -> RangeBody {
    return [positions, edges, out = lengths.data()](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        const float* const a = positions.data() + 3 * std::size_t{edges[2 * e]};
        const float* const b = positions.data() + 3 * std::size_t{edges[2 * e + 1]};
        const double x = double{a[0]} - b[0], y = double{a[1]} - b[1], z = double{a[2]} - b[2];
        out[e] = static_cast<float>(std::sqrt(x * x + y * y + z * z));
      }
    };
  });
  return lengths;
}

}  // namespace mesh_map
