#ifndef MESH_MAP_SRC_EDGES_H
#define MESH_MAP_SRC_EDGES_H

#include <mesh_map/topology.h>

namespace mesh_map {

/// First stage of buildTopology: fills edges, face_edges, edge_face_counts, edge_flags and
/// face_flags. The faces are known to name existing vertices; face_flags may be unset.
void buildEdges(ArrayView<std::uint32_t> faces, unsigned threads, Topology& topology);

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_EDGES_H
