#ifndef MESH_MAP_SRC_WALK_MESH_ARRAYS_H
#define MESH_MAP_SRC_WALK_MESH_ARRAYS_H

#include <mesh_map/walk.h>

#include <vector>

#include "array_checks.h"

namespace mesh_map {

/// A mesh to walk on; keeps its arrays, which are checked once.
class WalkMeshArrays
{
 public:
  WalkMeshArrays(const py::array& vertices, const py::array& faces, const py::array& face_edges,
                 const py::array& face_flags, const py::array& edge_face_offsets,
                 const py::array& edge_faces)
      : arrays_{vertices, faces, face_edges, face_flags, edge_face_offsets, edge_faces}
  {
    mesh_.mesh = meshView(vertices, faces);
    mesh_.face_edges = view<std::uint32_t>(face_edges, "face_edges", {faces.shape(0), 3});
    mesh_.face_flags = view<std::uint8_t>(face_flags, "face_flags", {faces.shape(0)});
    mesh_.edge_faces =
        rowsView(edge_face_offsets, edge_faces, mesh_.mesh.faceCount(), "edge_faces");
    const py::gil_scoped_release release;
    checkWalkMesh(mesh_);
  }

  const WalkMesh& mesh() const { return mesh_; }

  /// One value for each face; empty for None.
  ArrayView<std::uint8_t> maskOf(const py::object& mask) const
  {
    const auto count = static_cast<py::ssize_t>(mesh_.mesh.faceCount());
    return mask.is_none() ? ArrayView<std::uint8_t>()
                          : view<std::uint8_t>(py::cast<py::array>(mask), "mask", {count});
  }

 private:
  std::vector<py::array> arrays_;
  WalkMesh mesh_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_WALK_MESH_ARRAYS_H
