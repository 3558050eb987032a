#include "level_of_detail/simplification.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <unordered_map>
#include <utility>

#include "base/vectors.h"
#include "level_of_detail/mesh_border.h"

#ifdef HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace rviz_mesh_plugin {

#ifdef HAVE_MESHOPTIMIZER

namespace {

/// So few faces are drawn at once at any distance.
constexpr std::size_t FEW_FACES = 1000;
/// Nor does a level with less than one face of so many save anything: the draw calls of the parts
/// take longer, and its faces reach far out of the parts.
constexpr std::size_t COARSEST = 64;
/// A coarser grid would show nothing of the mesh.
constexpr int LEAST_CELLS = 8;
/// Where one vertex of so many lies on a border, faces share hardly any: there is no border to see.
constexpr std::size_t MUCH_BORDER = 8;

/// Merges the vertices in each cell of a grid into one of them; faces that have all their corners
/// in less than three cells vanish. Faces outside the region, which are few, stay.
class Simplifier
{
 public:
  /// Most cells along the longest side of the region.
  static constexpr int MOST_CELLS = 998;

  /// @param vertices have to live as long as this
  Simplifier(const std::vector<MeshVertex>& vertices, const MeshRegion& region)
      : region_(region), vertices_(vertices)
  {
    // The grid of meshoptimizer lies over the vertices it is given.
    MeshRegion grid;
    static_cast<Bounds&>(grid) = Bounds::none();
    for (const MeshVertex& vertex : vertices) {
      const auto position = region.whole ? vertex.position : region.clamp(vertex.position);
      grid.enclose(position);
      if (!region.whole) {
        clamped_.push_back(position);
      }
    }
    extent_ = grid.hasExtent() ? grid.extent() : 0.0f;
    origin_ = grid.lower;
  }

  /// Three indices into the vertices per face.
  /// @param cells along the longest side of the region, 2 to MOST_CELLS
  std::vector<std::uint32_t> simplify(const std::vector<std::uint32_t>& indices, int cells) const
  {
    std::vector<std::uint32_t> inside;
    std::vector<std::uint32_t> outside;
    if (!region_.whole) {
      inside.reserve(indices.size());
      for (auto face = indices.begin(); face != indices.end(); face += 3) {
        const bool keep = isOutside(face[0]) || isOutside(face[1]) || isOutside(face[2]);
        auto& faces = keep ? outside : inside;
        faces.insert(faces.end(), face, face + 3);
      }
    }
    const auto& faces = region_.whole ? indices : inside;
    std::vector<std::uint32_t> simplified(faces.size());
    const float* positions =
        region_.whole ? vertices_.front().position.data() : clamped_.front().data();
    const std::size_t stride = region_.whole ? sizeof(MeshVertex) : sizeof(clamped_.front());
    // Limited by the error alone, meshoptimizer rounds the coordinates to 0 .. 1 / error - 1.
    const float error = 1.0f / (static_cast<float>(cells) + 1.5f);
    simplified.resize(meshopt_simplifySloppy(simplified.data(), faces.data(), faces.size(),
                                             positions, vertices_.size(), stride, 0, error,
                                             nullptr));
    simplified.insert(simplified.end(), outside.begin(), outside.end());
    return simplified;
  }

  /// Puts a vertex of @a border in place of each one of @a simplified in whose cell there is one,
  /// so that an open border stays where it is.
  /// @param cells as in simplify()
  void keepBorder(const std::vector<std::uint32_t>& border, int cells,
                  std::vector<std::uint32_t>* simplified) const
  {
    if (border.empty()) {
      return;
    }
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> candidates;
    for (const std::uint32_t vertex : border) {
      if (!isOutside(vertex)) {
        candidates[cell(vertex, cells)].push_back(vertex);
      }
    }
    std::vector<std::uint32_t> places(vertices_.size(), NONE);
    for (std::uint32_t& index : *simplified) {
      if (places[index] == NONE) {
        places[index] = index;
        const auto found =
            isOutside(index) ? candidates.end() : candidates.find(cell(index, cells));
        if (found != candidates.end()) {
          // The farthest: next to a corner, that is the corner.
          const auto away = [this, index](std::uint32_t vertex) {
            return distance(vertices_[index].position, vertices_[vertex].position);
          };
          places[index] = *std::max_element(
              found->second.begin(), found->second.end(),
              [&](std::uint32_t a, std::uint32_t b) { return away(a) < away(b); });
        }
      }
      index = places[index];
    }
  }

  /// In meters. No corner is moved further than the diagonal of a cell. 0 where all vertices are in
  /// one place: there is nothing to simplify.
  float cellSize(int cells) const { return extent_ / cells; }

 private:
  bool isOutside(std::uint32_t vertex) const
  {
    return !region_.whole && clamped_[vertex] != vertices_[vertex].position;
  }

  std::uint64_t cell(std::uint32_t vertex, int cells) const
  {
    const auto& position = vertices_[vertex].position;
    std::uint64_t id = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float place = (position[axis] - origin_[axis]) * (1.0f / extent_);
      id = id << 20 | static_cast<std::uint64_t>(place * static_cast<float>(cells) + 0.5f);
    }
    return id;
  }

  const MeshRegion region_;
  const std::vector<MeshVertex>& vertices_;
  std::vector<std::array<float, 3>> clamped_;  ///< only where the region is not the whole
  std::array<float, 3> origin_{};              ///< of the grid
  float extent_ = 0.0f;
};

}  // namespace

std::vector<SimplifiedLevel> simplifyInLevels(const std::vector<MeshVertex>& vertices,
                                              const std::vector<std::uint32_t>& indices,
                                              const MeshRegion& region, float edge,
                                              const std::atomic<bool>& canceled)
{
  std::vector<SimplifiedLevel> levels;
  const Simplifier simplifier(vertices, region);
  const float extent = simplifier.cellSize(1);
  if (!(extent > 0.0f)) {
    return levels;
  }
  const float wanted = edge > 0.0f ? extent / (2.0f * edge) : Simplifier::MOST_CELLS;
  int cells = static_cast<int>(std::min<float>(wanted, Simplifier::MOST_CELLS));
  const std::size_t few = std::max(3 * FEW_FACES, indices.size() / COARSEST);
  std::vector<std::uint32_t> border = borderVertices(indices, vertices.size());
  if (border.size() > vertices.size() / MUCH_BORDER) {
    border.clear();
  }
  const std::vector<std::uint32_t>* finer = &indices;
  for (; cells >= LEAST_CELLS && finer->size() > few && !canceled; cells /= 2) {
    SimplifiedLevel level{simplifier.cellSize(cells), simplifier.simplify(*finer, cells)};
    if (level.indices.empty()) {
      break;
    }
    if (3 * level.indices.size() <= finer->size()) {
      simplifier.keepBorder(border, cells, &level.indices);
      level.indices.shrink_to_fit();
      levels.push_back(std::move(level));
      finer = &levels.back().indices;
    }
  }
  return levels;
}

#else

std::vector<SimplifiedLevel> simplifyInLevels(const std::vector<MeshVertex>& /*vertices*/,
                                              const std::vector<std::uint32_t>& /*indices*/,
                                              const MeshRegion& /*region*/, float /*edge*/,
                                              const std::atomic<bool>& /*canceled*/)
{
  return {};
}

#endif

}  // namespace rviz_mesh_plugin
