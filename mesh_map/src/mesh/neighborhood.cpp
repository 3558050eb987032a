#include <mesh_map/mesh/neighborhood.h>

#include <mesh_map/base/parallel.h>

#include <cstddef>

namespace mesh_map {

namespace {

constexpr std::size_t VERTICES_PER_CHUNK = 32768;

}  // namespace

std::vector<PackedPosition> packPositions(ArrayView<float> positions)
{
  std::vector<PackedPosition> packed(positions.size() / 3);
  parallelEach(packed.size(), VERTICES_PER_CHUNK, 0,
               [from = positions.data(), to = packed.data()](std::size_t v) {
                 to[v] = {from[3 * v], from[3 * v + 1], from[3 * v + 2], 0.0f};
               });
  return packed;
}

RadiusNeighborhood::RadiusNeighborhood(const std::vector<PackedPosition>& positions,
                                       const RowsView& neighbors)
    : positions_(positions.data()),
      offsets_(neighbors.offsets.data()),
      neighbors_(neighbors.values.data()),
      stamps_(positions.size(), NO_INDEX),
      found_(1)
{
}

ArrayView<std::uint32_t> RadiusNeighborhood::find(std::uint32_t v, double radius)
{
  // Local copies: what is written below could be a member, as far as the compiler knows.
  const PackedPosition* const positions = positions_;
  const std::uint32_t* const offsets = offsets_;
  const std::uint32_t* const neighbors = neighbors_;
  std::uint32_t* const stamps = stamps_.data();
  std::uint32_t* found = found_.data();

  const PackedPosition center = positions[v];
  const double squared_radius = radius * radius;
  found[0] = v;
  stamps[v] = v;
  // Ring by ring: first all that the last one leads to, then what of that is within the radius.
  // Both loops are without a branch, which would be mispredicted all along the rim.
  std::size_t first = 0, count = 1;
  while (first < count) {
    std::size_t seen = count;
    for (std::size_t i = first; i < count; ++i) {
      const std::uint32_t begin = offsets[found[i]], end = offsets[found[i] + 1];
      if (seen + (end - begin) > found_.size()) {
        found_.resize(2 * (seen + (end - begin)));
        found = found_.data();
      }
      for (std::uint32_t k = begin; k < end; ++k) {
        const std::uint32_t to = neighbors[k];
        found[seen] = to;
        seen += stamps[to] != v;
        stamps[to] = v;
      }
    }
    first = count;
    for (std::size_t i = first; i < seen; ++i) {
      const std::uint32_t to = found[i];
      const double x = double{positions[to].x} - center.x;
      const double y = double{positions[to].y} - center.y;
      const double z = double{positions[to].z} - center.z;
      found[count] = to;
      count += x * x + y * y + z * z < squared_radius;
    }
  }
  return {found, count};
}

}  // namespace mesh_map
