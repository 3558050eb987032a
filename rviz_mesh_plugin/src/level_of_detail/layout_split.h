#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "level_of_detail/mesh_layout.h"
#include "level_of_detail/sorted_mesh.h"

namespace rviz_mesh_plugin {

/// The faces of a layout in full, in the order in which they are cut into parts.
struct SplitFaces
{
  std::vector<std::uint32_t> indices;    ///< three per face, into the vertices of the layout
  std::vector<std::uint32_t> materials;  ///< BY_MATERIAL: of each face, in ascending order
};

/// Makes the vertices of a layout out of those of the mesh: as many of each as its faces need.
class LayoutSplit
{
 public:
  virtual ~LayoutSplit() = default;

  /// Fills vertices, sources and texture coordinates of the layout, in the order in which the faces
  /// use the vertices first.
  virtual SplitFaces split(const SortedMesh& mesh, MeshLayout& layout) = 0;

  /// The corners, as vertices of the layout, of a simplified face that is given as vertices of the
  /// sorted mesh; after split(). The first corner is a vertex of the part that the face belongs to.
  /// May add vertices.
  virtual std::array<std::uint32_t, 3> corners(const std::uint32_t* face, MeshLayout& layout) = 0;
};

/// @param materials for BY_MATERIAL; have to live as long as the result
std::unique_ptr<LayoutSplit> makeSplit(Split split, const Materials* materials);

}  // namespace rviz_mesh_plugin
