#include "level_of_detail/vertex_clusters.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace rviz_mesh_plugin {
namespace {

using Face = std::array<std::uint32_t, 3>;

/// So many vertices or faces are looked at in one go.
constexpr std::size_t CHUNK = 65536;

/// A grid over a region.
class Grid
{
 public:
  Grid(const MeshRegion& region, int cells) : region_(region), scale_(cells / region.extent())
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float side = (region.upper[axis] - region.lower[axis]) * scale_;
      last_[axis] = std::min(static_cast<std::uint32_t>(side), static_cast<std::uint32_t>(cells));
    }
  }

  std::size_t cellCount() const
  {
    return std::size_t{last_[0] + 1} * (last_[1] + 1) * (last_[2] + 1);
  }

  /// NONE outside of the region.
  std::uint32_t cell(const std::array<float, 3>& position) const
  {
    if (!region_.whole && !region_.contains(position)) {
      return NONE;
    }
    return (step(position, 2) * (last_[1] + 1) + step(position, 1)) * (last_[0] + 1) +
           step(position, 0);
  }

  /// The square of the distance to the middle of its cell, in cells.
  float offCenter(const std::array<float, 3>& position) const
  {
    float sum = 0.0f;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float off =
          (position[axis] - region_.lower[axis]) * scale_ - step(position, axis) - 0.5f;
      sum += off * off;
    }
    return sum;
  }

 private:
  std::uint32_t step(const std::array<float, 3>& position, std::size_t axis) const
  {
    return std::min(static_cast<std::uint32_t>((position[axis] - region_.lower[axis]) * scale_),
                    last_[axis]);
  }

  MeshRegion region_;
  float scale_;
  std::array<std::uint32_t, 3> last_{};
};

/// The vertex of each cell that is nearest to its middle.
std::vector<std::uint32_t> middleVertices(const MeshData& mesh, const Grid& grid,
                                          const std::vector<std::uint32_t>& cells)
{
  std::vector<std::uint32_t> middles(grid.cellCount(), NONE);
  std::vector<float> least(grid.cellCount(), std::numeric_limits<float>::max());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] != NONE) {
      const float off = grid.offCenter(mesh.vertices[i].position);
      if (off < least[cells[i]]) {
        least[cells[i]] = off;
        middles[cells[i]] = static_cast<std::uint32_t>(i);
      }
    }
  }
  return middles;
}

/// With the lowest corner first: what is equal is then the same.
Face turned(const Face& face)
{
  Face turned = face;
  std::rotate(turned.begin(), std::min_element(turned.begin(), turned.end()), turned.end());
  return turned;
}

}  // namespace

std::vector<std::uint32_t> clusterVertices(const MeshData& mesh, const MeshRegion& region,
                                           int cells)
{
  const Grid grid(region, cells);
  std::vector<std::uint32_t> of_vertices(mesh.vertexCount());
  mesh_map::parallelEach(mesh.vertexCount(), CHUNK, 0,
                         [&grid, vertices = mesh.vertices.data(), to = of_vertices.data()](
                             std::size_t i) { to[i] = grid.cell(vertices[i].position); });
  const std::vector<std::uint32_t> middles = middleVertices(mesh, grid, of_vertices);

  std::vector<std::vector<Face>> kept(mesh.faceCount() / CHUNK + 1);
  mesh_map::parallelFor(mesh.faceCount(), CHUNK, 0, [&]() -> mesh_map::RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      std::vector<Face>& faces = kept[begin / CHUNK];
      const std::uint32_t* index = mesh.indices.data() + 3 * begin;
      for (std::size_t i = begin; i < end; ++i, index += 3) {
        const Face cell{of_vertices[index[0]], of_vertices[index[1]], of_vertices[index[2]]};
        if (cell[0] == NONE || cell[1] == NONE || cell[2] == NONE) {
          faces.push_back({index[0], index[1], index[2]});
        } else if (cell[0] != cell[1] && cell[1] != cell[2] && cell[2] != cell[0]) {
          faces.push_back(turned({middles[cell[0]], middles[cell[1]], middles[cell[2]]}));
        }
      }
    };
  });
  std::vector<Face> faces;
  for (const std::vector<Face>& chunk : kept) {
    faces.insert(faces.end(), chunk.begin(), chunk.end());
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * faces.size());
  for (const Face& face : faces) {
    indices.insert(indices.end(), face.begin(), face.end());
  }
  return indices;
}

}  // namespace rviz_mesh_plugin
