#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Normals of faces.
struct FaceNormals
{
  std::vector<float> normals;              ///< 3 per face, of length 1
  std::vector<std::uint8_t> without_area;  ///< 1 for every face without area
};

/// (v1 - v0) x (v2 - v0) by length, computed in double precision. A face without area (two corners
/// in one place, or all three on a line, as far as double precision tells) has the fallback.
FaceNormals faceNormals(const MeshView& mesh, const std::array<float, 3>& fallback);

/// Interior angles of faces at their corners in radians, 3 per face; 0 where they cannot be told.
std::vector<float> cornerAngles(const MeshView& mesh);

/// What vertexNormals() reads.
struct VertexNormalsInput
{
  ArrayView<std::uint32_t> faces;
  ArrayView<float> face_normals;
  RowsView vertex_faces;            ///< the faces around each vertex
  ArrayView<std::uint8_t> ignored;  ///< 1 for faces that do not count
  ArrayView<float> corner_angles;   ///< weights; empty where all faces count the same
  std::array<float, 3> fallback = {0.0f, 0.0f, 1.0f};  ///< where that leaves nothing
};

/// Unit normals of the vertices: the mean of the unit normals of the faces around (H. Gouraud:
/// Continuous Shading of Curved Surfaces, 1971). Thresholds in
/// the field were chosen for that without weights.
std::vector<float> vertexNormals(const VertexNormalsInput& input);

/// The angle between two directions of length 1 in radians, 0 to pi, good for the smallest angles
/// too (the arc cosine of their product is not).
double angleBetween(const float* a, const float* b);

/// For each vertex the mean angle between its normal and those of its neighbors (3 floats each, of
/// length 1); 0 for one without neighbors. The order of the neighbors does not matter.
std::vector<float> meanEdgeAngles(ArrayView<float> normals, ArrayView<std::uint32_t> edges,
                                  const RowsView& neighbor_edges);

/// The angle between each normal (3 floats, of length 1) and a direction of length 1.
std::vector<float> anglesTo(ArrayView<float> normals, const std::array<double, 3>& direction);

}  // namespace mesh_map
