#ifndef MESH_MAP_FOOTPRINT_VERTICES_H
#define MESH_MAP_FOOTPRINT_VERTICES_H

#include <mesh_map/footprint.h>

#include <cstdint>
#include <vector>

namespace mesh_map {

/// The vertices under footprints: those of pose i are vertices[offsets[i]] to
/// vertices[offsets[i + 1] - 1], ascending.
struct FootprintVertices
{
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint32_t> vertices;
};

/// The vertices that say what the ground under a footprint is: each stands for those points of its
/// faces to which it is the nearest corner, and counts if one of these points is in the band (its
/// border included). Arguments and exceptions are those of footprintCosts().
FootprintVertices footprintVertices(const Bvh& bvh, const MeshView& mesh,
                                    const Footprint& footprint, ArrayView<double> poses,
                                    const BvhOptions& run = {});

}  // namespace mesh_map

#endif  // MESH_MAP_FOOTPRINT_VERTICES_H
