#pragma once

#include <string>

#include <mesh_msgs/MeshGeometry.h>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Why a mesh that breaks no rule is not seen as it is, in a sentence with the numbers and the way
/// out; empty where it is. Vertices so far from the origin that float32, in which they are drawn,
/// keeps them less exactly than a tenth of the median edge; all vertices in one point; all faces
/// without an area.
/// @param geometry that the mesh was converted from
/// @param mesh with its bounds
std::string findRemark(const mesh_msgs::MeshGeometry& geometry, const MeshData& mesh);

}  // namespace rviz_mesh_plugin
