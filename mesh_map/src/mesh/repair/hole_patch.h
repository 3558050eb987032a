#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/vector3.h"

namespace mesh_map {

/// A hole to be closed: its loop in the order of the faces that close it.
struct HoleLoop
{
  std::vector<Vector3> points;
  std::vector<Vector3> beside;  ///< the normal of the face at the edge from each point to the next;
                                ///< 0 where it has none
  std::vector<double> spacing;  ///< at each point the length of edges around
  Vector3 normal;               ///< of its best plane, of length 1
};

/// Whether the mesh has an edge between two points of the loop.
using EdgeTest = std::function<bool(std::size_t, std::size_t)>;

/// The faces that close a hole: the points of its loop, and new ones behind them.
struct HolePatch
{
  using Face = std::array<std::uint32_t, 3>;
  std::vector<Vector3> points;
  std::vector<Face> faces;
  /// Of each new point the three points of the loop that it is between, and weights, 1 together.
  std::vector<std::array<std::uint32_t, 3>> sources;
  std::vector<Vector3> weights;
};

/// Closes a loop without new points: of all triangulations that have no edge of the mesh twice, the
/// one that bends the least, and of those with the smallest area (P. Liepa: Filling holes in
/// meshes, 2003; G. Barequet and M. Sharir: Filling gaps in the boundary of a polyhedron, 1995).
/// Longer loops are cut ear by ear in their best plane. Then edges are flipped to the shorter side
/// where the circle through three corners contains the fourth. No faces where there is no such
/// triangulation.
HolePatch closedHole(const HoleLoop& loop, const EdgeTest& has_edge);

/// Puts points into a patch until its edges are as long as those around (Liepa, section 4), and
/// moves them to the middle of their neighbors.
void refinePatch(const HoleLoop& loop, const EdgeTest& has_edge, HolePatch& patch);

/// The largest angle (radians, 0 to pi) between faces of a patch that have an edge in common, and
/// between them and the faces beside the loop; pi where one of the patch has no area.
double largestFold(const HoleLoop& loop, const HolePatch& patch);

}  // namespace mesh_map
