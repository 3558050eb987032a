#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "rviz_mesh_plugin/layout_split.h"
#include "rviz_mesh_plugin/mesh_layout.h"
#include "rviz_mesh_plugin/simplification.h"

namespace rviz_mesh_plugin {

/// Cuts the faces of a layout, whose vertices are there, into parts and fills in parts, indices and
/// cell sizes.
class LayoutParts
{
 public:
  LayoutParts(const SplitFaces& faces, MeshLayout& layout);

  /// From fine to coarse; writes the layout's indices.
  void write(const std::vector<SimplifiedLevel>& levels, LayoutSplit& split);

 private:
  using Face = std::array<std::uint32_t, 3>;

  void fillParts();
  std::vector<std::uint32_t> placeFaces(const SimplifiedLevel& level, LayoutSplit& split,
                                        std::vector<IndexRange>& ranges);
  std::vector<std::uint32_t> partsOf(const Face& face) const;
  std::vector<std::vector<std::uint32_t>> partsOfAll(const std::vector<Face>& faces) const;
  bool sameMaterial(std::uint32_t a, std::uint32_t b) const;
  void enclose(MeshPart& part, std::uint32_t vertex) const;

  const SplitFaces& faces_;
  MeshLayout& layout_;
  std::size_t vertex_count_;                  ///< without copies that levels need
  std::vector<std::size_t> begins_;           ///< first face of each part, and the end
  std::vector<std::uint32_t> vertex_begins_;  ///< first vertex that each part is the first to use
};

}  // namespace rviz_mesh_plugin
