#pragma once

#include <atomic>
#include <cstddef>

#include <mesh_msgs/MeshGeometryStamped.h>

#include "base/mesh_data.h"
#include "conversion/attribute_conversion.h"
#include "conversion/validation.h"

namespace rviz_mesh_plugin {

/// Coordinates beyond this (in meters) are refused: OGRE squares them in 32-bit floats.
constexpr float GREATEST_COORDINATE = 1e15f;

/// Checks the message and makes what MeshVisual uploads. Normals are scaled to length 1; where the
/// message has none, they are computed from the faces. @throw RejectedMessage
MeshDataConstPtr convert(const mesh_msgs::MeshGeometryStamped& message);

/// Whether convert() would make this very mesh of the message, to the last bit: takes a fraction of
/// its time, and no memory.
bool isConverted(const mesh_msgs::MeshGeometryStamped& message, const MeshData& mesh);

/// How many messages convert() has been given in this process, for tests.
extern std::atomic<std::size_t> conversions;

/// Sets each normal to the mean direction of the faces around the vertex, weighted by their area;
/// (0, 0, 0) where the faces cancel out, have no area, or there is none.
void computeNormals(MeshData& mesh);

}  // namespace rviz_mesh_plugin
