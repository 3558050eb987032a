#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "base/mesh_data.h"
#include "measurement/section_graph.h"

namespace rviz_mesh_plugin {

/// What lies within a gap of a section: of the connected surfaces that have been followed up to it,
/// what looks to the same side, each part from where it begins along the line as far as it leads,
/// in their order. Of those one above the other the one that is nearest to the straight line over
/// the gap. Upright parts that lead from one to the next belong to them.
/// @param faces of the two points
/// @param followed the paths from the two points
/// @throw Canceled (cancellation.h), std::bad_alloc
std::vector<SectionPath> findIslands(const MeshData& mesh, const SectionGraph& graph,
                                     const std::vector<std::uint32_t>& faces,
                                     const std::array<SectionPath, 2>& followed,
                                     const SectionNode& begin, const SectionNode& end,
                                     const std::atomic<bool>* cancel);

}  // namespace rviz_mesh_plugin
