#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/mesh/topology.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vector3.h"
#include "mesh/repair/border_loops.h"

namespace mesh_map {

/// What became of a loop.
enum class HoleFate : std::uint8_t
{
  FILLED = 0,
  OUTER = 1,     ///< the longest of its component, and half as large as that
  LONG = 2,      ///< its perimeter is over the limit
  UNEVEN = 3,    ///< it leaves its best plane too far
  STEEP = 4,     ///< its best plane is too steep
  FOLDED = 5,    ///< what would close it lies back on the surface, or has no area
  CROSSING = 6,  ///< what would close it crosses the surface, or what closes another one
};

struct HoleLimits
{
  double perimeter = 1.0;            ///< meters; longer loops stay
  double flatness = 0.1;             ///< distance from the best plane, in parts of the perimeter
  double slope = PI;                 ///< radians, of the best plane
  double fold = 150.0 / 180.0 * PI;  ///< radians between faces side by side
  bool keep_outer = true;
  bool refine = true;
  Vector3 up = {0.0, 0.0, 1.0};
  std::size_t face_limit = 10'000'000;  ///< so many new ones at most: std::length_error
};

/// The shape of loops, a row for each, and which of them are within the limits.
struct LoopShapes
{
  std::vector<std::uint8_t> fates;  ///< HoleFate: FILLED where nothing of the shape is against it
  std::vector<double> perimeters;   ///< meters
  std::vector<double> deviations;   ///< meters from the best plane
  std::vector<Vector3> normals;     ///< of the best planes, of length 1
};

/// Takes the topology and the loops of this mesh. The same with any number of threads.
LoopShapes loopShapes(const MeshView& mesh, const Topology& topology, const BorderLoops& loops,
                      const HoleLimits& limits, unsigned threads);

}  // namespace mesh_map
