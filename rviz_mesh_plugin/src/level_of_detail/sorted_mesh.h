#pragma once

#include <cstdint>
#include <vector>

#include "base/mesh_data.h"
#include "level_of_detail/mesh_region.h"

namespace rviz_mesh_plugin {

/// A mesh with its faces in an order in which near faces are near to each other, and its vertices
/// in the order in which these faces use them first; vertices without a face are left out.
struct SortedMesh
{
  std::vector<std::uint32_t> faces;    ///< of the mesh, by place
  std::vector<std::uint32_t> sources;  ///< vertices of the mesh, by place
  std::vector<MeshVertex> vertices;    ///< by place
  std::vector<std::uint32_t> indices;  ///< places of vertices, three per face
};

/// Without meshoptimizer the faces keep the order of the mesh.
SortedMesh sortInSpace(const std::vector<MeshVertex>& vertices,
                       const std::vector<std::uint32_t>& indices, const MeshRegion& region);

}  // namespace rviz_mesh_plugin
