#include "radius_block.h"

#include <mesh_map/parallel.h>

namespace mesh_map {
namespace {

template <class T>
void copy(const std::vector<RadiusGrid::Range>& ranges, const LargeArray<T>& from,
          std::size_t width, LargeArray<T>& to)
{
  to.clear();
  if (!from.empty()) {
    for (const auto& [begin, end] : ranges) {
      to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(width * begin),
                from.begin() + static_cast<std::ptrdiff_t>(width * end));
    }
  }
}

}  // namespace

OrderedMesh inOrderOf(const RadiusGrid& grid, const RadiusQuery& query)
{
  constexpr std::size_t vertices_per_chunk = 32768;
  const std::size_t count = grid.order().size();
  const ArrayView<std::uint32_t> order = {grid.order().data(), count};
  OrderedMesh mesh;
  mesh.attributes = gatherAttributes(query, order);
  const std::uint32_t* const offsets = query.neighbors.offsets.data();
  LargeArray<std::uint32_t> places(count);
  mesh.offsets.resize(count + 1);
  mesh.offsets[0] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t v = order[i];
    places[v] = static_cast<std::uint32_t>(i);
    mesh.offsets[i + 1] = mesh.offsets[i] + (offsets[v + 1] - offsets[v]);
  }
  mesh.neighbors.resize(query.neighbors.values.size());
  parallelFor(count, vertices_per_chunk, query.threads, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t v = order[i];
        std::uint32_t* to = mesh.neighbors.data() + mesh.offsets[i];
        for (std::uint32_t k = offsets[v]; k < offsets[v + 1]; ++k) {
          *to++ = places[query.neighbors.values[k]];
        }
      }
    };
  });
  return mesh;
}

void Block::gather(const std::vector<RadiusGrid::Range>& ranges)
{
  places_.clear();
  for (const auto& [begin, end] : ranges) {
    for (std::uint32_t place = begin; place < end; ++place) {
      local_[place] = static_cast<std::uint32_t>(places_.size());
      places_.push_back(place);
    }
  }
  const RadiusAttributes& from = mesh_.attributes;
  copy(ranges, from.x, 1, attributes.x);
  copy(ranges, from.y, 1, attributes.y);
  copy(ranges, from.z, 1, attributes.z);
  copy(ranges, from.heights, 1, attributes.heights);
  copy(ranges, from.angles, 1, attributes.angles);
  copy(ranges, from.normals, 3, attributes.normals);

  offsets.assign(1, 0);
  neighbors.clear();
  for (const std::uint32_t place : places_) {
    for (std::uint32_t k = mesh_.offsets[place]; k < mesh_.offsets[place + 1]; ++k) {
      const std::uint32_t to = mesh_.neighbors[k], local = local_[to];
      if (local < places_.size() && places_[local] == to) {
        neighbors.push_back(local);
      }
    }
    offsets.push_back(static_cast<std::uint32_t>(neighbors.size()));
  }
}

}  // namespace mesh_map
