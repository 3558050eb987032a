#include <mesh_map/mesh/edge_faces.h>

#include "base/require.h"
#include "base/rows.h"

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
  EdgeFaces rows;
  rows.offsets = fillRows(edge_count, rows.faces, [&](const auto& put) {
    for (std::size_t face = 0; face < face_edges.size() / 3; ++face) {
      const std::uint32_t* const sides = face_edges.data() + 3 * face;
      for (std::size_t k = 0; k < 3 && !isDegenerate(sides); ++k) {
        require(sides[k] < edge_count, "a face has an edge that does not exist");
        put(sides[k], static_cast<std::uint32_t>(face));
      }
    }
  });
  return rows;
}

}  // namespace mesh_map
