#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "level_of_detail/layout_split.h"
#include "level_of_detail/mesh_layout.h"
#include "level_of_detail/simplification.h"

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
  using Meeting = std::uint64_t;  ///< a vertex, and in the lower half a part
  using FaceBeside = std::pair<std::uint32_t, std::uint32_t>;  ///< a part, a face

  void fillParts();
  std::vector<IndexRange> placeFaces(const SimplifiedLevel& level, LayoutSplit& split);
  std::vector<FaceBeside> facesBeside(const std::vector<Face>& faces) const;
  std::vector<Meeting> meetings(const std::vector<Face>& faces) const;
  bool isAbroad(std::uint32_t vertex, std::uint32_t part) const;
  bool sameMaterial(std::uint32_t a, std::uint32_t b) const;

  const SplitFaces& faces_;
  MeshLayout& layout_;
  std::vector<std::size_t> begins_;  ///< first face of each part, and the end
  /// The first one to use it, without copies that levels need.
  std::vector<std::uint32_t> part_of_vertex_;
};

}  // namespace rviz_mesh_plugin
