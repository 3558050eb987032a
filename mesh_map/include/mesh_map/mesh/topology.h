#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Bits of Topology::edge_flags.
enum EdgeFlag : std::uint8_t
{
  EDGE_BORDER = 1,        ///< one face
  EDGE_NON_MANIFOLD = 2,  ///< more than two faces
  EDGE_INCONSISTENT =
      4  ///< two faces that run along it in the same direction: one of them is flipped
};

/// Bits of Topology::face_flags.
enum FaceFlag : std::uint8_t
{
  FACE_DEGENERATE = 1,  ///< names a vertex twice
  FACE_DUPLICATE = 2    ///< has the three vertices of a face of lower index, in any order
};

/// Bits of Topology::vertex_flags.
enum VertexFlag : std::uint8_t
{
  VERTEX_NON_MANIFOLD = 1,  ///< its faces do not form one fan, or it lies on a non-manifold edge
  VERTEX_ISOLATED = 2       ///< no edge reaches it
};

/// What is next to what in a triangle soup. Every face is kept: nothing is repaired or left out.
///
/// Edges are the sorted pairs (a, b), a < b, of different vertices that follow each other in some
/// face, in lexicographic order. Degenerate faces add their edges, but are not counted as faces of
/// them.
struct Topology
{
  std::size_t vertex_count = 0;
  std::size_t face_count = 0;
  std::size_t component_count = 0;

  std::vector<std::uint32_t> edges;  ///< 2 per edge
  std::vector<std::uint32_t>
      face_edges;  ///< 3 per face; k is between corners k and k + 1; or NO_INDEX
  std::vector<std::uint32_t> edge_face_counts;  ///< faces that are not degenerate, per edge
  std::vector<std::uint8_t> edge_flags;         ///< EdgeFlag bits
  std::vector<std::uint8_t> face_flags;         ///< FaceFlag bits
  std::vector<std::uint8_t> vertex_flags;       ///< VertexFlag bits

  std::vector<std::uint32_t>
      neighbor_offsets;                  ///< rows of neighbors and neighbor_edges, one per vertex
  std::vector<std::uint32_t> neighbors;  ///< vertices, ascending in each row
  std::vector<std::uint32_t> neighbor_edges;       ///< the edge to each of them
  std::vector<std::uint32_t> vertex_face_offsets;  ///< rows of vertex_faces, one per vertex
  std::vector<std::uint32_t> vertex_faces;         ///< faces, ascending in each row, each once

  std::vector<std::int32_t>
      components;  ///< per vertex, numbered in the order of their lowest vertices

  std::size_t edgeCount() const { return edges.size() / 2; }
};

/// Builds the topology of any list of faces in O(V + F) (a vertex with very many edges costs a sort
/// of these). Throws std::invalid_argument where a face names no vertex or the mesh is too large
/// for 32-bit indices.
Topology buildTopology(ArrayView<std::uint32_t> faces, std::size_t vertex_count,
                       unsigned threads = 0);

/// Lengths of edges (2 vertices each), computed in double precision.
std::vector<float> edgeLengths(ArrayView<float> positions, ArrayView<std::uint32_t> edges);

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
