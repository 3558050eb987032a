#ifndef MESH_MAP_SRC_GEODESIC_FUNNEL_H
#define MESH_MAP_SRC_GEODESIC_FUNNEL_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geodesic_strip.h"

namespace mesh_map {

/// A vertex at which a taut path bends, and the portals (first to last) that end there.
struct Bend
{
  std::uint32_t vertex;
  std::size_t first, last;
};

/// Where the shortest path through an unfolded strip bends, in its order. In linear time.
std::vector<Bend> funnel(const Unfolding& strip);

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_GEODESIC_FUNNEL_H
