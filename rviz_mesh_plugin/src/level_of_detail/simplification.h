#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "base/mesh_data.h"
#include "level_of_detail/mesh_region.h"

namespace rviz_mesh_plugin {

struct SimplifiedLevel
{
  float cell_size = 0.0f;  ///< in meters
  std::vector<std::uint32_t> indices;
};

/// Ever coarser levels, each made of the one before, with a third of its faces at most, until there
/// are few; none without meshoptimizer. Where @a canceled becomes true, the levels so far.
/// @param region faces outside, which are few, stay as they are
/// @param edge a typical one, in meters: the first cells are twice as large
std::vector<SimplifiedLevel> simplifyInLevels(const std::vector<MeshVertex>& vertices,
                                              const std::vector<std::uint32_t>& indices,
                                              const MeshRegion& region, float edge,
                                              const std::atomic<bool>& canceled);

}  // namespace rviz_mesh_plugin
