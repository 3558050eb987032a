#include "rviz_mesh_plugin/simplification.h"

#include <algorithm>
#include <array>
#include <utility>

#ifdef HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace rviz_mesh_plugin {
namespace {

/// So few faces are drawn at once at any distance.
constexpr std::size_t FEW_FACES = 1000;
/// Nor does a level with less than one face of so many save anything: the draw calls of the parts
/// take longer, and its faces reach far out of the parts.
constexpr std::size_t COARSEST = 256;
/// A coarser grid would show nothing of the mesh.
constexpr int LEAST_CELLS = 8;

}  // namespace

#ifdef HAVE_MESHOPTIMIZER

bool canSimplify()
{
  return true;
}

Simplifier::Simplifier(const std::vector<MeshVertex>& vertices, const MeshRegion& region)
    : region_(region), extent_(0.0f), count_(vertices.size()), vertices_(&vertices)
{
  // The grid of meshoptimizer lies over the vertices it is given.
  MeshRegion grid;
  grid.lower = grid.upper = region.clamp(vertices.front().position);
  for (const MeshVertex& vertex : vertices) {
    const auto position = region.whole ? vertex.position : region.clamp(vertex.position);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      grid.lower[axis] = std::min(grid.lower[axis], position[axis]);
      grid.upper[axis] = std::max(grid.upper[axis], position[axis]);
    }
    if (!region.whole) {
      clamped_.push_back(position);
    }
  }
  extent_ = grid.hasExtent() ? grid.extent() : 0.0f;
}

std::vector<std::uint32_t> Simplifier::simplify(const std::vector<std::uint32_t>& indices,
                                                int cells) const
{
  if (!(extent_ > 0.0f)) {
    return indices;
  }
  std::vector<std::uint32_t> inside;
  std::vector<std::uint32_t> outside;
  if (!region_.whole) {
    const auto is_outside = [this](std::uint32_t index) {
      return clamped_[index] != (*vertices_)[index].position;
    };
    inside.reserve(indices.size());
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
      const bool keep =
          is_outside(indices[i]) || is_outside(indices[i + 1]) || is_outside(indices[i + 2]);
      auto& faces = keep ? outside : inside;
      faces.insert(faces.end(), indices.begin() + i, indices.begin() + i + 3);
    }
  }
  const auto& faces = region_.whole ? indices : inside;
  std::vector<std::uint32_t> simplified(faces.size());
  const float* positions =
      region_.whole ? vertices_->front().position.data() : clamped_.front().data();
  const std::size_t stride = region_.whole ? sizeof(MeshVertex) : sizeof(clamped_.front());
  // Limited by the error alone, meshoptimizer rounds the coordinates to 0 .. 1 / error - 1.
  const float error = 1.0f / (static_cast<float>(cells) + 1.5f);
  simplified.resize(meshopt_simplifySloppy(simplified.data(), faces.data(), faces.size(), positions,
                                           count_, stride, 0, error, nullptr));
  simplified.insert(simplified.end(), outside.begin(), outside.end());
  return simplified;
}

#else

bool canSimplify()
{
  return false;
}

Simplifier::Simplifier(const std::vector<MeshVertex>& vertices, const MeshRegion& region)
    : region_(region), extent_(0.0f), count_(vertices.size()), vertices_(&vertices)
{
}

std::vector<std::uint32_t> Simplifier::simplify(const std::vector<std::uint32_t>& indices,
                                                int /*cells*/) const
{
  return indices;
}

#endif

std::vector<SimplifiedLevel> simplifyInLevels(const Simplifier& simplifier,
                                              const std::vector<std::uint32_t>& indices, float edge,
                                              const std::atomic<bool>& cancelled)
{
  std::vector<SimplifiedLevel> levels;
  const float extent = simplifier.cellSize(1);
  if (!canSimplify() || !(extent > 0.0f)) {
    return levels;
  }
  const float wanted = edge > 0.0f ? extent / (2.0f * edge) : Simplifier::MOST_CELLS;
  int cells = static_cast<int>(std::min<float>(wanted, Simplifier::MOST_CELLS));
  const std::size_t few = std::max(3 * FEW_FACES, indices.size() / COARSEST);
  const std::vector<std::uint32_t>* finer = &indices;
  for (; cells >= LEAST_CELLS && finer->size() > few && !cancelled; cells /= 2) {
    SimplifiedLevel level{simplifier.cellSize(cells), simplifier.simplify(*finer, cells)};
    if (level.indices.empty()) {
      break;
    }
    if (3 * level.indices.size() <= finer->size()) {
      level.indices.shrink_to_fit();
      levels.push_back(std::move(level));
      finer = &levels.back().indices;
    }
  }
  return levels;
}

}  // namespace rviz_mesh_plugin
