#pragma once

#include <cstddef>
#include <vector>

#include "paths/geodesic_legs.h"
#include "paths/geodesic_turn.h"

namespace mesh_map {

/// Throws std::invalid_argument for what shortenPath() does not accept.
void checkPath(const WalkMesh& mesh, const WalkTrace& path, ArrayView<std::uint8_t> mask);

inline Vector3 pointAt(const WalkTrace& path, std::size_t i)
{
  return {path.points[3 * i], path.points[3 * i + 1], path.points[3 * i + 2]};
}

/// A part of a path between two joints that is to be straightened in its strip, or to stay.
struct Stretch
{
  Strip strip;
  bool stays;
};

/// A path as stretches, and the joints at both ends of each, one more. A joint has its vertex only
/// where the stretches on both sides may move (or that is an end).
struct Stretches
{
  std::vector<Stretch> stretches;
  std::vector<Joint> joints;
};

Stretches stretchesOf(const FaceChoice& choice, const WalkTrace& path);

}  // namespace mesh_map
