#include <mesh_map/mesh/edge_faces.h>

#include <stdexcept>

namespace mesh_map {

namespace {

/// A face that names a vertex twice has a side that is no edge.
bool isDegenerate(const std::uint32_t* sides)
{
  return sides[0] == NO_INDEX || sides[1] == NO_INDEX || sides[2] == NO_INDEX;
}

}  // namespace

EdgeFaces edgeFaces(ArrayView<std::uint32_t> face_edges, std::size_t edge_count)
{
  // Filling moves each row's end; offset i + 2 is counted, so that offset i + 1 ends up as the end
  // of row i.
  EdgeFaces rows;
  rows.offsets.assign(edge_count + 2, 0);
  std::uint32_t* const ends = rows.offsets.data() + 1;
  const std::size_t size = face_edges.size() / 3 * 3;
  for (std::size_t i = 0; i < size; ++i) {
    if (isDegenerate(face_edges.data() + i / 3 * 3)) {
      continue;
    }
    if (face_edges[i] >= edge_count) {
      throw std::invalid_argument("a face has an edge that does not exist");
    }
    ++ends[face_edges[i] + 1];
  }
  for (std::size_t e = 1; e <= edge_count; ++e) {
    ends[e] += ends[e - 1];
  }
  rows.faces.resize(ends[edge_count]);
  for (std::size_t i = 0; i < size; ++i) {
    if (!isDegenerate(face_edges.data() + i / 3 * 3)) {
      rows.faces[ends[face_edges[i]]++] = static_cast<std::uint32_t>(i / 3);
    }
  }
  rows.offsets.pop_back();
  return rows;
}

}  // namespace mesh_map
