#ifndef MESH_MAP_SRC_GEODESIC_TAUT_H
#define MESH_MAP_SRC_GEODESIC_TAUT_H

#include <mesh_map/geodesic.h>

#include <cstddef>
#include <optional>

#include "geodesic_input.h"
#include "geodesic_legs.h"
#include "geodesic_turn.h"

namespace mesh_map {

/// A path that is being pulled taut.
class TautPath
{
 public:
  TautPath(const FaceChoice& choice, const GeodesicOptions& options)
      : choice_(choice), options_(options)
  {
  }

  /// False where that cannot be told.
  bool take(const Stretches& path);

  /// Until nothing is left to gain, or `passes` passes are made.
  void settle(Geodesic& result, std::size_t passes);

  /// The other side of all hills beside it; true if the path is another one then.
  bool tryHills(Geodesic& result);

  WalkTrace trace() const;

 private:
  bool pass(Geodesic& result);
  void cutLoops();
  std::optional<Legs> around(const Joint& joint, const Leg& after, const Joint& to);
  std::optional<Legs> overHills(const Leg& leg, const Joint& from, const Joint& to,
                                Geodesic& result);
  bool isCancelled(Geodesic& result) const;

  const FaceChoice choice_;
  const GeodesicOptions options_;
  Joint start_{}, end_{};
  Legs way_;
  std::size_t tried_ = 0;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_GEODESIC_TAUT_H
