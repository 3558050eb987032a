#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// A mesh without edges of more than two faces, and where the faces of each vertex are one fan.
struct ManifoldMesh
{
  std::vector<std::uint32_t> faces;           ///< 3 per face, in the order of their parents
  std::vector<std::uint32_t> face_parents;    ///< 1 per face
  std::vector<std::uint32_t> vertex_parents;  ///< 2 per vertex: itself twice, or the ends of an
                                              ///< edge in the middle of which it lies
  std::size_t degenerate_faces = 0;           ///< left out
  std::size_t duplicate_faces = 0;            ///< left out
  std::size_t split_vertices = 0;             ///< copies that vertices have got
  std::size_t split_edges = 0;                ///< vertices in the middle of edges
};

/// Faces that name a vertex twice, or have the vertices of a face before them, are left out. At an
/// edge of more than two faces, those two go on in each other that are turned alike and bend the
/// least, then the next two; vertices get a copy for each further fan of faces. Where the copies at
/// both ends of such an edge are the same (the way around leads from one pair to the other), each
/// further pair gets a vertex of its own in the middle of the edge.
///
/// Vertices come first, in their order, then copies and middles. Places do not change.
ManifoldMesh makeManifold(const MeshView& mesh);

}  // namespace mesh_map
