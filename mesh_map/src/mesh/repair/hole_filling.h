#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
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

/// New vertices and faces, to be put behind those of the mesh; and what became of each loop.
struct HoleFilling
{
  BorderLoops loops;
  std::vector<std::uint8_t> fates;            ///< HoleFate, one per loop
  std::vector<double> perimeters;             ///< meters, one per loop
  std::vector<double> deviations;             ///< meters from the best plane, one per loop
  std::vector<float> points;                  ///< 3 per new vertex
  std::vector<std::uint32_t> vertex_parents;  ///< 3 per new vertex
  std::vector<double> vertex_weights;         ///< 3 per new vertex, 1 together
  std::vector<std::uint32_t> faces;           ///< 3 per new face
  std::vector<std::uint32_t> face_parents;    ///< of the nearest side of the loop, 1 per new face
};

/// Closes the loops of the border that are within the limits.
///
/// No face of the mesh changes. New faces are turned as those beside them, have no edge of the mesh
/// but those of the loop, and cross neither the mesh nor each other. The same with any number of
/// threads.
HoleFilling fillHoles(const MeshView& mesh, const HoleLimits& limits, unsigned threads = 0);

}  // namespace mesh_map
