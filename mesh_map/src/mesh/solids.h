#pragma once

#include <mesh_map/base/array_view.h>

#include <cstdint>
#include <vector>

namespace mesh_map {

/// The closed surfaces of a mesh: for each face the number of its solid, or NO_INDEX.
///
/// Faces belong together that share an edge of an even number of faces. They are a solid if each of
/// their edges is one of an even number: so one that stands on a floor and has vertices (but no
/// edges) in common with it is a solid, and the floor is none; two boxes with an edge in common are
/// one solid. Degenerate faces are no part of anything.
/// Numbered in the order of their lowest faces. How faces are turned does not matter.
///
/// Takes Topology::face_edges and face_flags. Throws std::invalid_argument for an edge that does
/// not exist.
std::vector<std::uint32_t> findSolids(ArrayView<std::uint32_t> face_edges,
                                      ArrayView<std::uint8_t> face_flags, std::size_t edge_count);

}  // namespace mesh_map
