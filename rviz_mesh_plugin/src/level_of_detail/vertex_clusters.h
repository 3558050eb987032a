#pragma once

#include <cstdint>
#include <vector>

#include "base/mesh_data.h"
#include "level_of_detail/mesh_region.h"

namespace rviz_mesh_plugin {

/// A coarse picture of a mesh in a fraction of the time that levels of detail take: all vertices in
/// one cell of a grid become the one that is nearest to its middle (vertex clustering:
/// J. Rossignac, P. Borrel: Multi-resolution 3D approximations for rendering complex scenes, 1993).
/// Faces whose corners lie in less than three cells vanish, equal ones are there once; those that
/// reach out of the region, which are few, stay.
/// @param region with an extent
/// @param cells along the longest side of the region, 1 to 1000; memory is their number cubed
/// @return three indices into the vertices of the mesh per face
std::vector<std::uint32_t> clusterVertices(const MeshData& mesh, const MeshRegion& region,
                                           int cells);

}  // namespace rviz_mesh_plugin
