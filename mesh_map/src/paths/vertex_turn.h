#pragma once

#include <mesh_map/paths/walk.h>

#include <cstddef>
#include <cstdint>

#include "base/vector3.h"
#include "paths/walk_face.h"

namespace mesh_map {

/// Where a walk goes on from a vertex.
struct VertexTurn
{
  WalkEnd end = WalkEnd::ARRIVED;  ///< BORDER or BLOCKED: nowhere
  std::uint32_t face = NO_INDEX;
  std::uint32_t right = NO_INDEX;  ///< the vertex on the edge of that face from which...
  double angle = 0.0;              ///< ...the direction has this angle, to the left
};

/// Where a direction leads from corner k of a face.
///
/// Where faces go all the way round the vertex, there is always a way on: with as much angle on
/// both sides, if the direction leads through the face to the vertex; else it points out of the
/// face to one side, and leads straight on in the faces unfolded on that side, their angles scaled.
///
/// Elsewhere it leads into the face at the vertex that contains it as seen along the normal of the
/// face: what is ahead there, and not the angles of the faces, tells whether the surface goes on.
/// Faces count that are not connected by edges, too. Only where the surface is folded away from
/// that view, so that it does not tell, it leads on as far as the faces unfolded on one side reach.
///
/// The mask does not bend the way: it tells whether it is blocked. Along an edge, the face on
/// either side will do.
VertexTurn turnAt(const WalkMesh& mesh, const FlatFace& face, std::size_t k,
                  const Vector2& direction, ArrayView<std::uint8_t> mask);

/// The face at corner k of a face that contains a direction as seen along `up`, the given one if it
/// does; of those that may be entered, or the given one. `end` is BORDER if none does.
VertexTurn seenAhead(const WalkMesh& mesh, const FlatFace& face, std::size_t k, const Vector3& up,
                     const Vector3& direction, ArrayView<std::uint8_t> mask);

}  // namespace mesh_map
