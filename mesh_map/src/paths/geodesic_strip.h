#pragma once

#include <mesh_map/paths/walk.h>

#include <array>
#include <cstddef>
#include <cstdint>
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
  std::uint32_t left, right;  ///< vertices
  Vector2 at_left, at_right;
  Vector2 along;  ///< unit vector from left to right; ahead is a quarter turn to its left
};

/// A strip laid into the plane, with a point in its first face and one in its last (the unfolding
/// of J. Mitchell, D. Mount, C. Papadimitriou: The Discrete Geodesic Problem, 1987).
struct Unfolding
{
  Unfolding(const WalkMesh& mesh, const Strip& strip, const Vector3& from, const Vector3& to);

  std::vector<Portal> portals;  ///< one per edge; none: the points have no place
  Vector2 from{}, to{};

  /// The direction to a point beside a portal, `side` of 1 (ahead) or -1; 0 where it is its left
  /// (or right) end.
  static Vector2 fromLeft(const WalkMesh& mesh, const Portal& portal, const Vector3& point,
                          double side);
  static Vector2 fromRight(const WalkMesh& mesh, const Portal& portal, const Vector3& point,
                           double side);

  /// For each portal, where the straight line between the two points crosses it: 0 (left) to 1.
  std::vector<double> crossings() const;
};

}  // namespace mesh_map
