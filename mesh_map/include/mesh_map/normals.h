#ifndef MESH_MAP_NORMALS_H
#define MESH_MAP_NORMALS_H

#include <mesh_map/array_view.h>

#include <cstdint>
#include <vector>

namespace mesh_map {

/// Unit normals of the faces, (v1 - v0) x (v2 - v0) by length, 3 floats each, computed in double
/// precision. A face without area has (0, 0, 1), as in the released mesh_map.
std::vector<float> faceNormals(const MeshView& mesh, unsigned threads = 0);

/// 1 for every face without area: two corners in one place, or all three on a line, as far as
/// double precision tells.
std::vector<std::uint8_t> facesWithoutArea(const MeshView& mesh, unsigned threads = 0);

/// Unit normals of the vertices: the mean of the unit normals of the faces around (each counts the
/// same, which is what thresholds in the field were chosen for). Faces of `ignored` (1 = ignore;
/// may be empty) do not count. (0, 0, 1) where that leaves nothing.
std::vector<float> vertexNormals(ArrayView<float> face_normals, const RowsView& vertex_faces,
                                 ArrayView<std::uint8_t> ignored, unsigned threads = 0);

}  // namespace mesh_map

#endif  // MESH_MAP_NORMALS_H
