#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/repair/border_loops.h"
#include "mesh/repair/hole_loops.h"

namespace mesh_map {

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
  std::vector<std::uint32_t> face_loops;      ///< the loop that it closes, 1 per new face
};

/// Closes the loops of the border that are within the limits.
///
/// No face of the mesh changes. New faces are turned as those beside them, have no edge of the mesh
/// but those of the loop, and cross neither the mesh nor each other. The same with any number of
/// threads.
HoleFilling fillHoles(const MeshView& mesh, const HoleLimits& limits, unsigned threads = 0);

}  // namespace mesh_map
