#ifndef MESH_MAP_SRC_WALK_START_H
#define MESH_MAP_SRC_WALK_START_H

#include <mesh_map/walk.h>

#include "walk_face.h"

namespace mesh_map {

/// Throws std::invalid_argument for a mask of another size.
void checkWalk(const WalkMesh& mesh, const WalkOptions& options);

/// The same direction, times a power of two such that its largest number is 1 to 2: no product of
/// such is too large or too small. 0 of 0.
Vector3 ofSizeOne(const Vector3& direction);

/// Whether there is such a face, the weights of its corners are those of a point in it, up to some
/// rounding, and `up` is finite.
bool canStart(const WalkMesh& mesh, const WalkPose& start);

/// A face along its longest edge; from the side from which its corners run counter-clockwise, or
/// the other one.
FlatFace longestSideFirst(const WalkMesh& mesh, std::uint32_t face, bool reversed);

/// The face of a start, seen from its side.
FlatFace startFace(const WalkMesh& mesh, const WalkPose& start);

/// An empty trace but for its first point.
void beginTrace(WalkTrace* trace, const Vector3& point);

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_WALK_START_H
