#ifndef MESH_MAP_SRC_FIELD_DETOUR_H
#define MESH_MAP_SRC_FIELD_DETOUR_H

#include <atomic>
#include <cstdint>
#include <vector>

#include "field_surface.h"

namespace mesh_map {

/// One leg of a way: straight in `face` to a place.
struct FieldLeg
{
  FieldPlace to;
  std::uint32_t face;
};

/// The shortest way along edges from a place to a vertex whose label is below `potential`, or to
/// the goal, however much it climbs in between; empty if there is none, or it was cancelled.
std::vector<FieldLeg> findDetour(const FieldSurface& surface, const FieldPlace& from,
                                 double potential, const std::atomic<bool>* cancel);

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_FIELD_DETOUR_H
