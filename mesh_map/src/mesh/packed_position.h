#pragma once

#include <mesh_map/mesh/neighborhood.h>

#include "base/vector3.h"

namespace mesh_map {

inline Vector3 between(const PackedPosition& from, const PackedPosition& to)
{
  return {double{to.x} - from.x, double{to.y} - from.y, double{to.z} - from.z};
}

}  // namespace mesh_map
