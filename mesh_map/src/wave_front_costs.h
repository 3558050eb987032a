#ifndef MESH_MAP_SRC_WAVE_FRONT_COSTS_H
#define MESH_MAP_SRC_WAVE_FRONT_COSTS_H

#include <mesh_map/array_view.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "wave_front_behind.h"
#include "wave_front_triangle.h"

namespace mesh_map {

/// What ways cost: along an edge, across a face.
template <bool HAS_COSTS>
class WaveFrontCosts
{
 public:
  explicit WaveFrontCosts(ArrayView<float> slowness) : slowness_(slowness.data()) {}

  bool isOpen(std::uint32_t v) const { return !HAS_COSTS || slowness_[v] < NOT_REACHED; }
  double slowness(std::uint32_t v) const { return HAS_COSTS ? double{slowness_[v]} : 1.0; }

  /// The time along an edge.
  double alongEdge(std::uint32_t a, std::uint32_t b, double length) const
  {
    return HAS_COSTS ? 0.5 * (slowness(a) + slowness(b)) * length : length;
  }

  void prefetch(std::uint32_t v) const
  {
    if (HAS_COSTS) {
      __builtin_prefetch(&slowness_[v]);
    }
  }

  /// What comes to the corner of a triangle across its base; `low` and `high` slowness of it and of
  /// the face behind. Where that is not less than `label`, it may be any that is not.
  static double front(double u, double v, const WaveFrontTriangle& triangle,
                      const WaveFrontSlowness& slowness, const WaveFrontBehind& behind, double low,
                      double high, double label)
  {
    if (!HAS_COSTS) {
      return evenFront(u, v, triangle, behind, label);
    }
    if (low == high) {
      return evenFront(u, v, triangle.scaled(low), behind.scaled(low), label);
    }
    if (isEven(low, high)) {
      return nearlyRoundFront(u, v, triangle, slowness, low, label);
    }
    const double base = slowness.onBase() * triangle.base;
    return std::fabs(u - v) <= base * (1.0 + 1e-9)
               ? unevenFront(u, v, triangle, slowness, low, high <= ROUND * low ? base : 0.0, label)
               : NOT_REACHED;
  }

  /// Is slowness within two neighboring faces, from `low` to `high`, about the same?
  static bool isEven(double low, double high) { return high <= EVEN * low; }

 private:
  /// Of slowness within two neighboring faces, the highest by the lowest: up to this, it is taken
  /// as the same for the way across.
  static constexpr double EVEN = 1.1;
  /// Up to this, the front is taken as round.
  static constexpr double ROUND = 1.3;
  /// What is above a label by less than this part is looked at more exactly.
  static constexpr double NEAR = 0.01;

  /// Where all is equally slow. What is a little above the label is looked at more exactly, too: so
  /// the result does not depend on which of two ways has come first.
  static double evenFront(double u, double v, const WaveFrontTriangle& triangle,
                          const WaveFrontBehind& behind, double label)
  {
    WaveFrontSource source;
    if (!findSource(u, v, triangle.base, source)) {
      return NOT_REACHED;
    }
    const double plain = roundFront(u, source, triangle);
    return plain < label * (1.0 + NEAR) && isEarlier(behind, source)
               ? std::min(plain, roundFrontFromBehind(u, v, triangle, source, behind))
               : plain;
  }

  const float* slowness_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_WAVE_FRONT_COSTS_H
