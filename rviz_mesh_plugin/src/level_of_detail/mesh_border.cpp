#include "level_of_detail/mesh_border.h"

namespace rviz_mesh_plugin {
namespace {

/// Spreads the index over all bits (the multiplier of splitmix64): sums of few are equal by chance
/// in one of 2^32 cases.
std::uint32_t scramble(std::uint32_t index)
{
  const std::uint64_t product = (std::uint64_t{index} + 1) * 0xbf58476d1ce4e5b9u;
  return static_cast<std::uint32_t>(product >> 32);
}

}  // namespace

std::vector<std::uint32_t> borderVertices(const std::vector<std::uint32_t>& indices,
                                          std::size_t vertex_count)
{
  // Around an inner vertex each neighbor comes next in one face and last in another: what is added
  // for the one is taken off for the other.
  std::vector<std::uint32_t> sums(vertex_count, 0);
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const std::uint32_t a = scramble(indices[i]);
    const std::uint32_t b = scramble(indices[i + 1]);
    const std::uint32_t c = scramble(indices[i + 2]);
    sums[indices[i]] += b - c;
    sums[indices[i + 1]] += c - a;
    sums[indices[i + 2]] += a - b;
  }
  std::vector<std::uint32_t> border;
  for (std::size_t vertex = 0; vertex < vertex_count; ++vertex) {
    if (sums[vertex] != 0) {
      border.push_back(static_cast<std::uint32_t>(vertex));
    }
  }
  return border;
}

}  // namespace rviz_mesh_plugin
