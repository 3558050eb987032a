#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "base/mesh_data.h"
#include "measurement/section_graph.h"

namespace rviz_mesh_plugin {

/// What lies within a gap of a section: of the connected surfaces of some faces, what looks to the
/// same side, each part from where it begins along the line as far as it leads, in their order. Of
/// those one above the other the one that is nearest to the straight line over the gap.
/// @param up whether they look up
/// @throw Canceled (cancellation.h), std::bad_alloc
std::vector<SectionPath> findIslands(const MeshData& mesh, const SectionGraph& graph,
                                     const std::vector<std::uint32_t>& faces, bool up,
                                     const SectionNode& begin, const SectionNode& end,
                                     const std::atomic<bool>* cancel);

}  // namespace rviz_mesh_plugin
