#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/mesh/topology.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Which faces to turn (to list their corners the other way round).
struct Orientation
{
  std::vector<std::uint8_t> turned;    ///< 1 per face that is to be turned
  std::vector<std::uint32_t> patches;  ///< per face that of it; NO_INDEX of degenerate faces
  std::size_t patch_count = 0;
  std::size_t conflicts = 0;  ///< edges of two faces that disagree afterwards: of Moebius strips
};

/// Turns faces so that the two faces of an edge agree, and most of each patch faces up.
///
/// A patch is what edges of exactly two faces connect. In each, all faces are made to agree with
/// that of lowest index, wherever that is possible: on a one-sided patch, some edges remain. Then
/// the patch is turned as a whole if it shows more of its back than of its front when seen from
/// above. Of one that shows as much of both, such as a closed surface, the outside becomes the
/// front; and one without volume stays as its first face is. Degenerate faces stay as they are.
///
/// face_edges, edge_face_counts and edge_flags are those of the topology; `up` is of length 1.
/// Throws std::invalid_argument where they are those of another mesh, as far as that would matter.
Orientation orientFaces(const MeshView& mesh, ArrayView<std::uint32_t> face_edges,
                        ArrayView<std::uint32_t> edge_face_counts,
                        ArrayView<std::uint8_t> edge_flags, const std::array<double, 3>& up);

}  // namespace mesh_map
