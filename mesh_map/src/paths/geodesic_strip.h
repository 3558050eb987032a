#pragma once

#include <mesh_map/paths/walk.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/vector3.h"
#include "paths/walk_face.h"

namespace mesh_map {

/// Faces one after the other: each shares an edge with the next.
struct Strip
{
  std::vector<std::uint32_t> faces;
  std::vector<std::uint32_t> edges;  ///< one less than faces

  /// Goes on across an edge. Across the one it came over, it goes back, or past the face between.
  void cross(std::uint32_t edge, std::uint32_t face);

  /// From one of its faces to another one.
  Strip part(std::size_t first, std::size_t last) const;

  /// Leaves out what leads around a vertex (or NO_INDEX) at the start, or at the end.
  void trim(const WalkMesh& mesh, std::uint32_t at_start, std::uint32_t at_end);
};

inline Vector3 pointOf(const WalkMesh& mesh, std::uint32_t vertex)
{
  return pointOf(position(mesh, vertex));
}

/// The place of an edge among those of a face; it is between the corners there and next.
std::size_t sideOf(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge);

/// The corner of a face opposite to one of its edges.
std::uint32_t apexOf(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge);

/// The two ends of an edge of a face.
std::array<std::uint32_t, 2> endsOf(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge);

bool hasCorner(const WalkMesh& mesh, std::uint32_t face, std::uint32_t vertex);

/// Whether the edge of a face has a length: across one without, nothing can be unfolded.
bool canCross(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge);

/// A point beside an edge from a to b: how far along it, and how far from it.
Vector2 besideEdge(const Vector3& a, const Vector3& b, const Vector3& point);

/// An edge of a strip in the plane. Directions are carried along, so that they stay as exact after
/// any number of faces however small these are.
struct Portal
{
  std::array<std::uint32_t, 2> ends;  ///< vertices: left, right
  std::array<Vector2, 2> at;          ///< where these are
  Vector2 along;  ///< unit vector from left to right; ahead is a quarter turn to its left
};

/// A strip laid into the plane, with a point in its first face and one in its last (the unfolding
/// of J. Mitchell, D. Mount, C. Papadimitriou: The Discrete Geodesic Problem, 1987).
struct Unfolding
{
  Unfolding(const WalkMesh& mesh, const Strip& strip, const Vector3& from, const Vector3& to);

  std::vector<Portal> portals;  ///< one per edge; none: the points have no place
  Vector2 from{}, to{};

  /// The direction from an end of a portal to a point beside it, `side` of 1 (ahead) or -1; 0 where
  /// it is that end.
  static Vector2 directionFrom(const WalkMesh& mesh, const Portal& portal, std::size_t end,
                               const Vector3& point, double side);

  /// For each portal, where the straight line between the two points crosses it: 0 (left) to 1.
  std::vector<double> crossings() const;
};

/// Which faces may be entered.
struct FaceChoice
{
  const WalkMesh& mesh;
  ArrayView<std::uint8_t> mask;

  bool allows(std::uint32_t face) const;

  /// Of a face that may be entered, the first such with the same corners: all are one place.
  std::uint32_t firstOf(std::uint32_t face) const;
};

/// The two edges of a face at one of its corners, and their other ends.
struct CornerSides
{
  std::uint32_t corner;
  std::array<std::uint32_t, 2> edges, ends;

  CornerSides(const WalkMesh& mesh, std::uint32_t face, std::uint32_t vertex) : corner(vertex)
  {
    const std::size_t k = slotOf(mesh, face, corner);
    edges = {mesh.face_edges[3 * std::size_t{face} + k],
             mesh.face_edges[3 * std::size_t{face} + (k + 2) % 3]};
    ends = {cornerOf(mesh, face, (k + 1) % 3), cornerOf(mesh, face, (k + 2) % 3)};
  }

  std::uint32_t otherEdge(std::uint32_t edge) const { return edges[edges[0] == edge ? 1 : 0]; }

  double angle(const WalkMesh& mesh) const
  {
    const Vector3 center = pointOf(mesh, corner);
    return angleBetween(pointOf(mesh, ends[0]) - center, pointOf(mesh, ends[1]) - center);
  }
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
