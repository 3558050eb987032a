#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

namespace mesh_map {

/// What following a field needs to know of a mesh. The arrays have to outlive all use; faces and
/// rows are taken as checked.
struct TraceMesh
{
  MeshView mesh;
  RowsView vertex_faces;               ///< of Topology
  ArrayView<std::uint8_t> face_flags;  ///< of Topology
};

/// A potential on a surface, as a front from a goal leaves it. Values at vertices tell those in
/// between: on an edge it is as if the front had come straight from the one point that has these
/// distances from both ends.
struct SurfaceField
{
  ArrayView<double> labels;   ///< per vertex, >= 0; anything else where the front did not come
  double limit = 0.0;         ///< labels up to this are final
  ArrayView<float> slowness;  ///< per vertex, by which lengths are multiplied; not finite: closed;
                              ///< empty for 1
  std::uint32_t goal_face = NO_INDEX;  ///< NO_INDEX where the front came from vertices
  std::array<double, 3> goal{};        ///< a point of goal_face
};

/// Throws std::invalid_argument unless rows and field are of the mesh, and the goal is on its face.
void checkField(const TraceMesh& mesh, const SurfaceField& field);

/// A way over the surface: point i to i + 1 is straight in face i.
struct FieldPath
{
  std::vector<double> points;  ///< 3 per point
  std::vector<std::uint32_t> faces;
  std::vector<double> potentials;
};

enum class TraceEnd : std::uint8_t
{
  ARRIVED = 0,      ///< at the goal, or after the length that was asked for
  NOT_REACHED = 1,  ///< the front did not come to the face of the start
  CANCELED = 2
};

/// Down the potential from a point to the goal: from where it crosses an edge, to where the way on
/// is the shortest of all in the faces there, looking ahead over the next faces. The crossing
/// points are exact, and vertices, borders and closed faces are passed as the front passed them.
/// Where the values leave no way down (noise, ridges where fronts met), it climbs along edges to
/// the nearest vertex that is lower. So it always arrives, and ends: each vertex is the lowest so
/// far at most once, and between two of them no edge is crossed many times.
///
/// Potentials fall from point to point; where the way climbs, they are interpolated between the two
/// points around that. No face with a closed corner is entered, but for that of the goal; that of
/// the start may be left. After `max_length` the way is cut off; what is before that is the same.
/// Throws std::invalid_argument for a start that is not on its face, or a length that is not >= 0.
TraceEnd tracePath(const TraceMesh& mesh, const SurfaceField& field, std::uint32_t face,
                   const std::array<double, 3>& start, const std::atomic<bool>* cancel,
                   FieldPath& path, double max_length = std::numeric_limits<double>::infinity());

/// The potential at a point of a face; infinite where the front did not come.
double fieldValue(const TraceMesh& mesh, const SurfaceField& field, std::uint32_t face,
                  const std::array<double, 3>& point);

/// Unit vectors down the potential, 3 floats per vertex, in the plane across `normals` (3 floats
/// per vertex); 0 where the front did not come, and at its sources. `front` is of the same mesh.
/// `threads`: 0 = all cores. Throws std::invalid_argument for numbers of another mesh.
LargeArray<float> vertexDirections(const TraceMesh& mesh, const FastMarchingMesh& front,
                                   const SurfaceField& field, ArrayView<float> normals,
                                   unsigned threads = 0);

/// Unit vectors down the potential in the middle of each face, 3 floats each, in its plane; 0 for
/// faces with a corner that the front did not reach, or without area.
LargeArray<float> faceDirections(const TraceMesh& mesh, const SurfaceField& field,
                                 unsigned threads = 0);

}  // namespace mesh_map
