#pragma once

#include <stdexcept>

#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

/// A message that cannot be shown; what() is one sentence for the status line.
class RejectedMessage : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// Coordinates beyond this (in meters) are refused: OGRE squares them in 32-bit floats.
constexpr float GREATEST_COORDINATE = 1e15f;

/// Checks the message and makes what MeshVisual uploads. Normals are scaled to length 1; where the
/// message has none, they are computed from the faces. @throw RejectedMessage
MeshDataConstPtr convert(const mesh_msgs::MeshGeometryStamped& message);

/// The number of costs is compared with the geometry later, which may not have arrived. @throw
/// RejectedMessage
CostLayerConstPtr convert(const mesh_msgs::MeshVertexCostsStamped& message);

/// As for costs. @throw RejectedMessage
ColorLayerConstPtr convert(const mesh_msgs::MeshVertexColorsStamped& message);

/// Sets each normal to the mean direction of the faces around the vertex, weighted by their area;
/// (0, 0, 0) where the faces cancel out, have no area, or there is none.
void computeNormals(MeshData& mesh);

}  // namespace rviz_mesh_plugin
