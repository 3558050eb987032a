#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Whether meshoptimizer was there when this library was built.
bool canSimplify();

struct SimplifiedFaces
{
  std::vector<std::uint32_t> faces;    ///< 3 per face, vertices of the mesh
  std::vector<std::uint32_t> regions;  ///< 1 per face
  double error = 0.0;                  ///< meters, as meshoptimizer measures it (by quadrics)
};

/// Fewer faces on some of the vertices of a mesh, by edge collapses (meshoptimizer).
///
/// Vertices on the border, on edges between faces of different regions, and of faces that are
/// frozen stay, and so do these edges and faces. Vertices at the same place are different vertices.
///
/// regions: a number for each face. frozen: 1 for each face that stays as it is. target: so many
/// faces are enough; max_error: meters. Throws std::logic_error where canSimplify() is false.
SimplifiedFaces simplifyFaces(const MeshView& mesh, ArrayView<std::uint32_t> regions,
                              ArrayView<std::uint8_t> frozen, std::size_t target, double max_error);

}  // namespace mesh_map
