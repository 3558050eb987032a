#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace rviz_mesh_plugin {

/// The vertices on open borders, ascending. Where neighbors are wound against each other, or more
/// than two faces share an edge, its vertices may be among them, too.
/// @param indices three per face
std::vector<std::uint32_t> borderVertices(const std::vector<std::uint32_t>& indices,
                                          std::size_t vertex_count);

}  // namespace rviz_mesh_plugin
