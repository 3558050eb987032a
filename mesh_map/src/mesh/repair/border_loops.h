#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/mesh/topology.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// The border of a mesh as simple loops: in none a vertex is twice.
struct BorderLoops
{
  std::vector<std::uint32_t> offsets;   ///< rows of vertices and faces, one per loop
  std::vector<std::uint32_t> vertices;  ///< in the order in which the faces beside run along them
  std::vector<std::uint32_t> faces;     ///< the face beside the edge from each vertex to the next
  std::size_t open_edges = 0;           ///< border edges that no loop has

  std::size_t size() const { return offsets.size() - 1; }
};

/// Follows the border around the fans of faces at its vertices, so that what bounds the same piece
/// of surface is one loop; where it comes back to a vertex, as where two holes touch, a loop ends.
///
/// Loops begin at the first of their sides in the order of the faces, and are in that order.
/// Border edges are open where the way around a vertex leads to an edge of more than two faces, or
/// to a face that is turned otherwise. Takes the topology of these faces.
BorderLoops borderLoops(ArrayView<std::uint32_t> faces, const Topology& topology);

}  // namespace mesh_map
