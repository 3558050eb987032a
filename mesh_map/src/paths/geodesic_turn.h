#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "paths/geodesic_strip.h"

namespace mesh_map {

/// Which faces may be entered.
struct FaceChoice
{
  const WalkMesh& mesh;
  ArrayView<std::uint8_t> mask;

  bool allows(std::uint32_t face) const;

  /// Of a face that may be entered, the first such with the same corners: all are one place.
  std::uint32_t firstOf(std::uint32_t face) const;
};

/// A direction in a face from one of its corners.
struct CornerDirection
{
  std::uint32_t face = NO_INDEX;
  std::array<std::uint32_t, 2> edges{};  ///< of the face at that corner
  std::array<double, 2> angles{};        ///< to each of them; infinite to one without length
};

/// Of a corner of a face, to a point of it.
CornerDirection directionTo(const WalkMesh& mesh, std::uint32_t face, std::uint32_t corner,
                            const Vector3& point);

/// Of the corner opposite to a portal (on its side 1, ahead, or -1), by the direction in the plane.
CornerDirection directionAlong(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge,
                               const Portal& portal, double side, const Vector2& direction);

/// A way around a vertex: faces between two, and the edges at the vertex that are crossed, one more
/// than faces (none of both within one face).
struct Turn
{
  std::vector<std::uint32_t> edges, faces;
};

/// The way from one ray to another around their vertex of the least angle, if that is below a
/// limit.
std::optional<Turn> turnBelow(const FaceChoice& choice, std::uint32_t vertex,
                              const CornerDirection& from, const CornerDirection& to, double limit);

}  // namespace mesh_map
