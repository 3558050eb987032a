#include <mesh_map/edge_faces.h>

#include <stdexcept>

namespace mesh_map {

EdgeFaces edgeFaces(ArrayView<std::uint32_t> face_edges, std::size_t edge_count)
{
  // Filling moves each row's end; offset i + 2 is counted, so that offset i + 1 ends up as the end
  // of row i.
  EdgeFaces rows;
  rows.offsets.assign(edge_count + 2, 0);
  std::uint32_t* const ends = rows.offsets.data() + 1;
  for (const std::uint32_t edge : face_edges) {
    if (edge != NO_INDEX && edge >= edge_count) {
      throw std::invalid_argument("a face has an edge that does not exist");
    }
    ends[edge == NO_INDEX ? 0 : edge + 1] += edge == NO_INDEX ? 0 : 1;
  }
  for (std::size_t e = 1; e <= edge_count; ++e) {
    ends[e] += ends[e - 1];
  }
  rows.faces.resize(ends[edge_count]);
  for (std::size_t i = 0; i < face_edges.size(); ++i) {
    if (face_edges[i] != NO_INDEX) {
      rows.faces[ends[face_edges[i]]++] = static_cast<std::uint32_t>(i / 3);
    }
  }
  rows.offsets.pop_back();
  return rows;
}

}  // namespace mesh_map
