#pragma once

#include <mesh_map/paths/walk.h>

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace mesh_map {

struct GeodesicOptions
{
  ArrayView<std::uint8_t> mask;  ///< per face: 0 = must not be entered; empty: all count
  bool over_hills = false;  ///< also try the other side of each vertex with less than 360 degrees
                            ///< beside the path, where a path that is as taut may be shorter
  std::size_t max_turns = 10000000;  ///< ways around a vertex that are tried
  const std::atomic<bool>* cancel = nullptr;
};

struct Geodesic
{
  WalkTrace path;
  double length = 0.0;
  std::size_t turns = 0;  ///< times that the path went to another side of a vertex
  bool settled = true;    ///< false: given up after max_turns; shorter than it was all the same
  bool canceled = false;  ///< then there is no path
};

/// The locally shortest path that a path over the surface becomes when it is pulled taut: as short
/// as it gets through the faces that it crosses, unfolded into the plane (a funnel in linear time:
/// D. T. Lee, F. P. Preparata: Euclidean Shortest Paths in the Presence of Rectilinear Barriers,
/// 1984); then, wherever it bends at a vertex with less than 180 degrees of surface on some side,
/// through the faces on that side, until nothing is left to gain (S.-Q. Xin, G.-J. Wang:
/// Efficiently Determining a Locally Exact Shortest Path on Polyhedral Surfaces, 2007). With that
/// no path near it is shorter; one on another side of a hill may be.
///
/// Both ends stay where they are. The result is never longer than what was given, and only enters
/// faces that count; parts of the path in others are kept where they do not run along the edge of
/// one that counts. Edges may have any number of faces, faces no area. The same numbers give the
/// same path.
///
/// Throws std::invalid_argument for a path whose points are not in its faces (the first is named),
/// or a mask of another size.
Geodesic shortenPath(const WalkMesh& mesh, const WalkTrace& path,
                     const GeodesicOptions& options = {});

}  // namespace mesh_map
