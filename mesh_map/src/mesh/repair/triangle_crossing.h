#pragma once

#include <array>

#include "base/vector3.h"

namespace mesh_map {

using Triangle = std::array<Vector3, 3>;

/// Whether two triangles cross or overlap. `shared`: which corners (bit k of the first mask: corner
/// k of `one`) they have in common; these do not count, and triangles with two of them never cross.
bool trianglesCross(const Triangle& one, unsigned shared_of_one, const Triangle& other,
                    unsigned shared_of_other);

}  // namespace mesh_map
