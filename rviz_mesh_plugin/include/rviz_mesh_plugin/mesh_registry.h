#pragma once

#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/mesh_layout.h"

namespace rviz_mesh_plugin {

/// The mesh that is in use in this process and has the same content, name and frame, to the last
/// bit; the given one where there is none. Keeps nothing alive. Thread safe.
MeshDataConstPtr internMesh(const MeshDataConstPtr& mesh);

/// The layout in use in this process that has been made of these, or null. Thread safe.
MeshLayoutConstPtr findLayout(const MeshDataConstPtr& mesh, Split split,
                              const MaterialsConstPtr& materials);

/// For findLayout(). Keeps nothing alive.
void rememberLayout(const MeshLayoutConstPtr& layout);

}  // namespace rviz_mesh_plugin
