#ifndef MESH_MAP_SRC_WAVE_FRONT_RING_H
#define MESH_MAP_SRC_WAVE_FRONT_RING_H

#include <mesh_map/front_mesh.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "wave_front_costs.h"

namespace mesh_map {

/// How much lower a label has to be to replace another one: a part of it, and the least step.
struct WaveFrontStep
{
  double least;

  bool isAbove(double label, double other) const { return other < label * (1.0 - PART) - least; }

  static constexpr double PART = 1e-6;
};

/// The vertices around one whose faces are in order, and what their labels become by it: what they
/// share is computed once.
template <bool HAS_COSTS>
class WaveFrontRing
{
 public:
  /// A vertex of the ring.
  struct Neighbor
  {
    std::uint32_t vertex;
    WaveFrontVector side;                           // to it
    double squared, length, label, slowness, time;  // along the edge to it
    double product, area;  // of its side and the next one; twice the area between
  };

  WaveFrontRing(const FrontMesh& mesh, const WaveFrontCosts<HAS_COSTS>& costs, const double* labels,
                WaveFrontStep step, std::uint32_t v)
      : step_(step), here_(labels[v]), slowness_(costs.slowness(v)), is_closed_(mesh.isClosed(v))
  {
    const FrontCorner* const corners = mesh.cornersBegin(v);
    faces_ = static_cast<std::size_t>(mesh.cornersEnd(v) - corners);
    count_ = is_closed_ ? faces_ : faces_ + 1;
    for (std::size_t i = 0; i < count_; ++i) {
      Neighbor& n = ring_[i];
      n.vertex = i < faces_ ? corners[i].a : corners[i - 1].b;
      n.slowness = costs.slowness(n.vertex);
      n.side = between(mesh.position(v), mesh.position(n.vertex));
      n.squared = dot(n.side, n.side);
      n.length = std::sqrt(n.squared);
      n.time = costs.alongEdge(v, n.vertex, n.length);
      n.label = labels[n.vertex];
    }
    for (std::size_t i = 0; i < faces_; ++i) {
      const WaveFrontVector &side = ring_[i].side, &next = ring_[i + 1 < count_ ? i + 1 : 0].side;
      ring_[i].product = dot(side, next);
      ring_[i].area = crossLength(side, next);
    }
  }

  /// Along the edges, then across the faces.
  void lowerLabels()
  {
    for (std::size_t i = 0; i < count_; ++i) {
      if (isOpen(ring_[i])) {
        offer(ring_[i], here_ + ring_[i].time);
      }
    }
    for (std::size_t i = 0; i < faces_; ++i) {
      const std::size_t j = i + 1 < count_ ? i + 1 : 0;
      const std::size_t before = i > 0 ? i - 1 : is_closed_ ? count_ - 1 : NONE;
      const std::size_t after = j + 1 < count_ ? j + 1 : is_closed_ ? 0 : NONE;
      if (mayLower(j, i, after)) {
        lower(ring_[j], ring_[i], ring_[after], ring_[i], ring_[j]);
      }
      if (mayLower(i, j, before)) {
        lower(ring_[i], ring_[j], ring_[before], ring_[i], ring_[before]);
      }
    }
  }

  const Neighbor* begin() const { return ring_; }
  const Neighbor* end() const { return ring_ + count_; }

 private:
  static constexpr std::size_t NONE = static_cast<std::size_t>(-1);

  /// Slowness at the corners of two faces.
  struct Range
  {
    double low, high;
  };

  static bool isOpen(const Neighbor& n) { return !HAS_COSTS || n.slowness < NOT_REACHED; }

  void offer(Neighbor& n, double label)
  {
    if (step_.isAbove(n.label, label)) {
      n.label = label;
    }
  }

  Range rangeOf(const Neighbor& a, const Neighbor& b, const Neighbor& c) const
  {
    return {std::min(std::min(slowness_, a.slowness), std::min(b.slowness, c.slowness)),
            std::max(std::max(slowness_, a.slowness), std::max(b.slowness, c.slowness))};
  }

  /// May the target get a lower label across the base from the middle to a neighbor? `other` is the
  /// third corner of the face on the other side. Where two labels differ by the time along an even
  /// base, the front comes along it.
  bool mayLower(std::size_t base, std::size_t target, std::size_t other) const
  {
    const Neighbor &b = ring_[base], &t = ring_[target];
    if (!(b.label < NOT_REACHED) || other == NONE || other == target || !(b.length > 0.0) ||
        !mesh_map::mayLower(t.label, here_, b.label, b.time)) {
      return false;
    }
    if (!HAS_COSTS) {
      return std::fabs(here_ - b.label) < b.time;
    }
    if (!(isOpen(b) && isOpen(t) && isOpen(ring_[other]))) {
      return false;
    }
    if (std::fabs(here_ - b.label) < b.time) {
      return true;
    }
    const Range range = rangeOf(b, t, ring_[other]);
    return !WaveFrontCosts<HAS_COSTS>::isEven(range.low, range.high);
  }

  /// Lowers it, if that is so. `face` and `face_behind` know the product and the area of the sides
  /// of the face of the target, and of that on the other side of the base.
  void lower(const Neighbor& base, Neighbor& target, const Neighbor& other, const Neighbor& face,
             const Neighbor& face_behind)
  {
    const double inverse = 1.0 / base.length;
    const Range range = HAS_COSTS ? rangeOf(base, target, other) : Range{1.0, 1.0};
    offer(target, WaveFrontCosts<HAS_COSTS>::front(
                      here_, base.label,
                      {base.length, face.product * inverse, face.area * inverse, target.squared},
                      {slowness_, base.slowness, target.slowness},
                      {face_behind.product * inverse, face_behind.area * inverse, other.label},
                      range.low, range.high, target.label));
  }

  Neighbor ring_[FrontMesh::MAX_FAN + 1];
  std::size_t faces_, count_;
  WaveFrontStep step_;
  double here_, slowness_;
  bool is_closed_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_WAVE_FRONT_RING_H
