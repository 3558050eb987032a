#ifndef MESH_MAP_SRC_GEODESIC_HILLS_H
#define MESH_MAP_SRC_GEODESIC_HILLS_H

#include <cstddef>
#include <cstdint>
#include <optional>

#include "geodesic_strip.h"
#include "geodesic_turn.h"

namespace mesh_map {

/// The strips that lead past a vertex beside a strip on its other side. Only vertices with less
/// than 360 degrees of surface around them are passed on both sides by taut paths (theorem of Gauss
/// and Bonnet), and only those that the surface goes all the way around can be.
class HillSides
{
 public:
  HillSides(const FaceChoice& choice, const Strip& strip) : choice_(choice), strip_(strip) {}

  /// One after the other; nothing at the end.
  std::optional<Strip> next();

 private:
  std::optional<Strip> around(std::uint32_t vertex, std::size_t first, std::size_t last) const;
  bool hasEnd(std::size_t edge, std::uint32_t vertex) const;

  const FaceChoice& choice_;
  const Strip& strip_;
  std::size_t edge_ = 0, end_ = 0;  // of the strip, and of its edge: what is to come
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_GEODESIC_HILLS_H
