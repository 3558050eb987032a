#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Puts faces in ascending order, each once. Takes long for many: not for the GUI thread.
void sortFaces(std::vector<std::uint32_t>& faces);

/// A label without the faces that a mesh of so many does not have; the same one where it has all.
LabelClusterConstPtr withinMesh(const LabelClusterConstPtr& label, std::size_t face_count);

}  // namespace rviz_mesh_plugin
