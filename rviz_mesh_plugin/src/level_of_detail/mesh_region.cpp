#include "level_of_detail/mesh_region.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/vectors.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t SAMPLED_FACES = 20000;
/// This part of the samples, at each end of each axis, may be strays.
constexpr std::size_t STRAY_PART = 200;

float quantile(std::vector<float>& values, std::size_t index)
{
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[index];
}

}  // namespace

MeshRegion mainRegion(const MeshData& mesh)
{
  MeshRegion region;
  static_cast<Bounds&>(region) = mesh;
  const std::size_t step = std::max<std::size_t>(1, mesh.faceCount() / SAMPLED_FACES);
  std::array<std::vector<float>, 3> samples;
  for (std::size_t face = 0; face < mesh.faceCount(); face += step) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      samples[axis].push_back(mesh.vertices[mesh.indices[3 * face]].position[axis]);
    }
  }
  const std::size_t count = samples[0].size();
  const std::size_t strays = count / STRAY_PART;
  if (strays == 0) {
    return region;
  }
  MeshRegion inner;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    inner.lower[axis] = quantile(samples[axis], strays);
    inner.upper[axis] = quantile(samples[axis], count - 1 - strays);
  }
  // A pillar on a flat floor is no stray: as much room on all sides.
  const float room = inner.extent();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    region.lower[axis] = std::max(mesh.lower[axis], inner.lower[axis] - room);
    region.upper[axis] = std::min(mesh.upper[axis], inner.upper[axis] + room);
  }
  region.whole = region.lower == mesh.lower && region.upper == mesh.upper;
  return region;
}

float typicalEdge(const MeshData& mesh)
{
  const std::size_t step = std::max<std::size_t>(1, mesh.faceCount() / SAMPLED_FACES);
  std::vector<float> lengths;
  for (std::size_t face = 0; face < mesh.faceCount(); face += step) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto index = static_cast<std::uint32_t>(face);
      lengths.push_back(static_cast<float>(
          distance(cornerOf(mesh, index, corner), cornerOf(mesh, index, (corner + 1) % 3))));
    }
  }
  return lengths.empty() ? 0.0f : quantile(lengths, lengths.size() / 2);
}

}  // namespace rviz_mesh_plugin
