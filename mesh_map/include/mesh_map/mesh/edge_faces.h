#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// The faces at each edge, ascending, in compressed rows.
struct EdgeFaces
{
  std::vector<std::uint32_t> offsets;  ///< one row per edge
  std::vector<std::uint32_t> faces;

  RowsView rows() const { return {offsets, faces}; }
};

/// Turns Topology::face_edges around. Degenerate faces are in no row. Throws std::invalid_argument
/// for an edge that does not exist.
EdgeFaces edgeFaces(ArrayView<std::uint32_t> face_edges, std::size_t edge_count);

}  // namespace mesh_map
