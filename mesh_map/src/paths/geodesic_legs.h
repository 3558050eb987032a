#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "paths/geodesic_strip.h"

namespace mesh_map {

/// Where two legs meet, or an end of the path.
struct Joint
{
  Vector3 position;
  std::uint32_t vertex;  ///< NO_INDEX: the path stays as it is here
  bool settled = false;  ///< there is no shorter way around it
};

/// A straight part of a path, through a strip.
struct Leg
{
  Strip strip;
  double length = 0.0;
  CornerDirection at_start{},
      at_end{};  ///< where it leaves its joints; without a face: not to be moved
};

/// Some legs, one after the other, and the joints between them.
struct Legs
{
  std::vector<Leg> legs;
  std::vector<Joint> joints;  ///< one less

  double length() const;
  void append(Legs&& more);
};

/// Legs between two ends.
struct JoinedPath
{
  Joint start, end;
  Legs legs;
};

inline Vector3 pointAt(const WalkTrace& path, std::size_t i)
{
  return {path.points[3 * i], path.points[3 * i + 1], path.points[3 * i + 2]};
}

/// Throws std::invalid_argument for what shortenPath() does not accept.
void checkPath(const WalkMesh& mesh, const WalkTrace& path, ArrayView<std::uint8_t> mask);

/// A path that was checked, each part that may move straight in its strip; nothing where that is
/// not to be told.
std::optional<JoinedPath> joined(const FaceChoice& choice, const WalkTrace& path);

/// The shortest way through a strip; nothing where that is not to be told (a strip whose faces do
/// not hang together).
std::optional<Legs> straighten(const WalkMesh& mesh, Strip strip, const Joint& from,
                               const Joint& to);

/// The points of a leg after its first one, up to its end.
void traceLeg(const WalkMesh& mesh, const Leg& leg, const Vector3& from, const Vector3& to,
              WalkTrace& trace);

}  // namespace mesh_map
