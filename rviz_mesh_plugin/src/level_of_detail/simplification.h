#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/mesh_data.h"
#include "level_of_detail/mesh_region.h"

namespace rviz_mesh_plugin {

/// False without meshoptimizer: there are no levels of detail then.
bool canSimplify();

/// Merges the vertices in each cell of a grid into one of them; faces that have all their corners
/// in less than three cells vanish. Faces outside the region, which are few, stay.
class Simplifier
{
 public:
  /// Most cells along the longest side of the region.
  static constexpr int MOST_CELLS = 998;

  /// @param vertices have to live as long as this
  Simplifier(const std::vector<MeshVertex>& vertices, const MeshRegion& region);

  /// Three indices into the vertices per face.
  /// @param cells along the longest side of the region, 2 to MOST_CELLS
  std::vector<std::uint32_t> simplify(const std::vector<std::uint32_t>& indices, int cells) const;

  /// Puts a vertex of @a border in place of each one of @a simplified in whose cell there is one,
  /// so that an open border stays where it is.
  /// @param cells as in simplify()
  void keepBorder(const std::vector<std::uint32_t>& border, int cells,
                  std::vector<std::uint32_t>* simplified) const;

  /// In meters. No corner is moved further than the diagonal of a cell.
  float cellSize(int cells) const { return extent_ / cells; }

  const MeshRegion& region() const { return region_; }
  std::size_t vertexCount() const { return count_; }

 private:
  bool isOutside(std::uint32_t vertex) const;
  std::uint64_t cell(std::uint32_t vertex, int cells) const;

  MeshRegion region_;
  std::array<float, 3> origin_{};  ///< of the grid
  float extent_;
  std::size_t count_;
  const std::vector<MeshVertex>* vertices_;
  std::vector<std::array<float, 3>> clamped_;  ///< only where the region is not the whole
};

struct SimplifiedLevel
{
  float cell_size = 0.0f;  ///< in meters
  std::vector<std::uint32_t> indices;
};

/// Ever coarser levels, each made of the one before, with a third of its faces at most, until there
/// are few. Where @a cancelled becomes true, the levels so far.
/// @param edge a typical one, in meters: the first cells are twice as large
std::vector<SimplifiedLevel> simplifyInLevels(const Simplifier& simplifier,
                                              const std::vector<std::uint32_t>& indices, float edge,
                                              const std::atomic<bool>& cancelled);

}  // namespace rviz_mesh_plugin
