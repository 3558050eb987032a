#include <mesh_map/walk.h>

#include <algorithm>
#include <stdexcept>

#include "walk_face.h"

namespace mesh_map {
namespace {

/// The vertices of a side of a face, the lower one first.
std::array<std::uint32_t, 2> sideOf(const WalkMesh& mesh, std::uint32_t face, std::size_t k)
{
  const std::uint32_t a = cornerOf(mesh, face, k), b = cornerOf(mesh, face, (k + 1) % 3);
  return {std::min(a, b), std::max(a, b)};
}

void require(bool condition)
{
  if (!condition) {
    throw std::invalid_argument("the topology is not that of the faces");
  }
}

}  // namespace

void checkWalkMesh(const WalkMesh& mesh)
{
  const std::size_t face_count = mesh.mesh.faceCount();
  require(mesh.face_edges.size() == 3 * face_count && mesh.face_flags.size() == face_count);
  std::size_t sides = 0;
  for (std::size_t i = 0; i < mesh.face_edges.size(); i += 3) {
    sides += std::count(mesh.face_edges.data() + i, mesh.face_edges.data() + i + 3, NO_INDEX) == 0
                 ? 3
                 : 0;
  }
  require(mesh.edge_faces.values.size() == sides);
  for (std::uint32_t edge = 0; edge < mesh.edge_faces.rowCount(); ++edge) {
    const std::uint32_t begin = mesh.edge_faces.offsets[edge];
    std::array<std::uint32_t, 2> vertices{};
    for (std::uint32_t i = begin; i < mesh.edge_faces.offsets[edge + 1]; ++i) {
      const std::uint32_t face = mesh.edge_faces.values[i];
      require(face < face_count && (i == begin || mesh.edge_faces.values[i - 1] < face));
      const std::uint32_t* const edges = mesh.face_edges.data() + 3 * std::size_t{face};
      const std::size_t k = static_cast<std::size_t>(std::find(edges, edges + 3, edge) - edges);
      require(k < 3 && std::count(edges, edges + 3, NO_INDEX) == 0);
      vertices = i == begin ? sideOf(mesh, face, k) : vertices;
      require(vertices == sideOf(mesh, face, k) && vertices[0] != vertices[1]);
    }
  }
}

}  // namespace mesh_map
