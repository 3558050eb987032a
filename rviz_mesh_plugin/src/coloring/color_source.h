#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Gives the colors of some vertices or faces of the mesh (LayoutOutline::sources). Called in
/// slices on the GUI thread, also much later: it owns what it reads.
using ColorSource =
    std::function<void(const std::uint32_t* sources, std::size_t count, Rgba8* colors)>;

}  // namespace rviz_mesh_plugin
