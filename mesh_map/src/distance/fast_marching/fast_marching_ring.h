#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "distance/fast_marching/fast_marching_behind.h"
#include "distance/fast_marching/fast_marching_triangle.h"
#include "distance/fast_marching/fast_marching_uneven.h"
#include "mesh/packed_position.h"

namespace mesh_map {

/// What ways cost: along an edge, across a face.
template <bool HAS_COSTS>
class FastMarchingCosts
{
 public:
  explicit FastMarchingCosts(ArrayView<float> slowness) : slowness_(slowness.data()) {}

  bool isOpen(std::uint32_t v) const { return !HAS_COSTS || slowness_[v] < NOT_REACHED; }
  double slowness(std::uint32_t v) const { return HAS_COSTS ? double{slowness_[v]} : 1.0; }

  /// The time along an edge.
  double alongEdge(std::uint32_t a, std::uint32_t b, double length) const
  {
    return HAS_COSTS ? 0.5 * (slowness(a) + slowness(b)) * length : length;
  }

  [[gnu::always_inline]] void prefetch(std::uint32_t v) const
  {
    if (HAS_COSTS) {
      __builtin_prefetch(&slowness_[v]);
    }
  }

  /// What comes to the corner of a triangle across its base; `low` and `high` slowness of it and of
  /// the face behind. Monotone in the labels. Where that is not less than `label`, it may be any
  /// that is not.
  [[gnu::always_inline]] static double front(double u, double v,
                                             const FastMarchingTriangle& triangle,
                                             const FastMarchingSlowness& slowness,
                                             const FastMarchingBehind& behind, double low,
                                             double high, double label)
  {
    if (!HAS_COSTS) {
      return evenUpdate(u, v, triangle, behind, label);
    }
    if (low == high) {
      return evenUpdate(u, v, triangle.scaled(low), behind.scaled(low), label);
    }
    const bool is_round = high <= ROUND * low;
    const double beyond = label - low * triangle.height;
    if (beyond <= 0.0 ||
        !mayLower(beyond, u, v, is_round ? slowness.onBase() * triangle.base : 0.0)) {
      return NOT_REACHED;
    }
    return FastMarchingUneven(u, v, triangle, slowness, is_round, low).least(label);
  }

 private:
  /// Of slowness within two neighboring faces, the highest by the lowest: up to this, the front is
  /// taken as round.
  static constexpr double ROUND = 1.3;

  const float* slowness_;
};

/// How much lower a label has to be to replace another one: a part of it, and the least step.
struct FastMarchingStep
{
  double least;

  bool isAbove(double label, double other) const { return other < label * (1.0 - PART) - least; }

  static constexpr double PART = 1e-7;
};

/// The vertices around one whose faces are in order, and what their labels become by it: what they
/// share is computed once. Sets of them are bits.
template <bool HAS_COSTS>
class FastMarchingRing
{
 public:
  /// `to_come`: all that has a label above this one passes it on itself, later.
  FastMarchingRing(const FastMarchingMesh& mesh, const FastMarchingCosts<HAS_COSTS>& costs,
                   const double* labels, FastMarchingStep step, double to_come, std::uint32_t v)
      : step_(step),
        here_(labels[v]),
        slowness_here_(costs.slowness(v)),
        is_closed_(mesh.isClosed(v))
  {
    const ArrayView<FastMarchingCorner> corners = mesh.corners(v);
    const std::size_t faces = corners.size();
    count_ = is_closed_ ? faces : faces + 1;
    for (std::size_t i = 0; i < count_; ++i) {
      Neighbor& n = ring_[i];
      n.vertex = i < faces ? corners[i].a : corners[i - 1].b;
      n.slowness = costs.slowness(n.vertex);
      n.label = labels[n.vertex];
      n.side = between(mesh.position(v), mesh.position(n.vertex));
      n.squared = dot(n.side, n.side);
      n.length = std::sqrt(n.squared);
      n.time = costs.alongEdge(v, n.vertex, n.length);
      final_ |= bit(i, n.label <= to_come && n.label < NOT_REACHED);
      open_ |= bit(i, !HAS_COSTS || n.slowness < NOT_REACHED);
    }
    for (std::size_t i = 0; i < faces; ++i) {
      const Vector3 &side = ring_[i].side, &next = ring_[i + 1 < count_ ? i + 1 : 0].side;
      const Vector3 normal = cross(side, next);
      ring_[i].product = dot(side, next);
      ring_[i].squared_area = dot(normal, normal);  // of slivers, too, which lengths would not tell
    }
  }

  std::size_t size() const { return count_; }
  std::uint32_t vertex(std::size_t i) const { return ring_[i].vertex; }
  double label(std::size_t i) const { return ring_[i].label; }
  /// Of the labels that a lowered one follows from.
  double highest(std::size_t i) const { return ring_[i].highest; }

  /// Along the edges, then across the faces. Calls lowered(i) for each that was lowered.
  template <class Lowered>
  void lowerLabels(const Lowered& lowered)
  {
    std::uint64_t changed = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const double label = here_ + ring_[i].time;
      const bool is_lower = step_.isAbove(ring_[i].label, label);
      ring_[i].label = is_lower ? label : ring_[i].label;
      ring_[i].highest = here_;
      changed |= bit(i, is_lower);
    }
    forEachBase([&](std::size_t base, std::size_t before, std::size_t after) {
      if (isSettled(base)) {
        changed |= lower({base, after, before, base, before});
        changed |= lower({base, before, after, before, base});
      }
    });
    forEachBit(changed, lowered);
  }

  /// Calls visit(w) for each w whose label may be what comes along the edge, or across a face.
  template <class Visit>
  void forEachFollowing(const Visit& visit)
  {
    std::uint64_t unseen = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (ring_[i].label < NOT_REACHED) {
        ring_[i].highest = mostOf(ring_[i].label);
        if (isIn(open_, i) && here_ + ring_[i].time <= ring_[i].highest) {
          visit(ring_[i].vertex);
        } else {
          unseen |= bit(i, true);
        }
      }
    }
    const auto look = [&](const Crossing& c) {
      const double most = ring_[c.target].highest;
      if (isIn(unseen, c.target) && mayFollow(c, most) && across(c, most) <= most) {
        visit(ring_[c.target].vertex);
        unseen &= ~bit(c.target, true);
      }
    };
    forEachBase([&](std::size_t base, std::size_t before, std::size_t after) {
      look({base, after, before, base, before});
      look({base, before, after, before, base});
    });
  }

  /// What is up to this may be what a label follows from: small differences are left as they are.
  static double mostOf(double label) { return label * (1.0 + 10.0 * FastMarchingStep::PART); }

  /// Calls visit(a, b) for the faces whose side opposite to the middle a front may cross that has
  /// been earlier in the middle than the labels of that side tell.
  template <class Visit>
  void forEachEarlier(const Visit& visit) const
  {
    if (!(slowness_here_ > 0.0)) {
      return;
    }
    const double scale = HAS_COSTS ? 1.0 / slowness_here_ : 1.0;
    const std::uint64_t closing = is_closed_ ? bit(count_ - 1, isIn(final_, 0)) : 0;
    forEachBit(final_ & (final_ >> 1 | closing), [&](std::size_t a) {
      const std::size_t b = a + 1 < count_ ? a + 1 : 0;
      if (HAS_COSTS &&
          (ring_[a].slowness != slowness_here_ || ring_[b].slowness != slowness_here_)) {
        return;
      }
      if (mayBeEarlier(here_ * scale, ring_[a].label * scale, ring_[b].label * scale,
                       ring_[a].squared + ring_[b].squared - 2.0 * ring_[a].product,
                       ring_[a].squared, ring_[a].squared - ring_[a].product,
                       ring_[a].squared_area)) {
        visit(ring_[a].vertex, ring_[b].vertex);
      }
    });
  }

 private:
  /// A way across a face: through the edge from the middle to `base`, to `target`. `other` is the
  /// third corner of the face on the other side of that edge. The face and that one are numbered
  /// as the first of their corners is.
  struct Crossing
  {
    std::size_t base, target, other, face, face_behind;
  };

  /// Slowness at the corners of two faces.
  struct Range
  {
    double low, high;
  };

  struct Neighbor
  {
    std::uint32_t vertex;
    Vector3 side;                                   // to it
    double squared, length, label, slowness, time;  // along the edge to it
    double highest;                // of the labels that a lowered one follows from, and more
    double product, squared_area;  // of its side and the next one; of the parallelogram between
  };

  static constexpr std::size_t SIZE = FastMarchingMesh::MAX_FAN + 1;
  static_assert(SIZE < 64, "a set of them is a word");

  static std::uint64_t bit(std::size_t i, bool is_set) { return std::uint64_t{is_set} << i; }
  static bool isIn(std::uint64_t set, std::size_t i) { return (set >> i & 1) != 0; }

  template <class Visit>
  static void forEachBit(std::uint64_t set, const Visit& visit)
  {
    for (; set != 0; set &= set - 1) {
      visit(static_cast<std::size_t>(__builtin_ctzll(set)));
    }
  }

  /// Calls visit(base, before, after) for each that a front may cross the edge to.
  template <class Visit>
  void forEachBase(const Visit& visit)
  {
    const std::size_t last = count_ - 1;
    const std::uint64_t ends = is_closed_ ? 0 : bit(0, true) | bit(last, true);
    if (count_ < 3) {
      return;  // the same face on both sides
    }
    forEachBit(final_ & open_ & ~ends, [&](std::size_t base) {
      if (ring_[base].length > 0.0) {
        visit(base, base > 0 ? base - 1 : last, base < last ? base + 1 : 0);
      }
    });
  }

  /// Where two labels differ by more than the time along the base, the higher one is about to
  /// become less, and then this is looked at again.
  bool isSettled(std::size_t base) const
  {
    const double label = ring_[base].label;
    return !step_.isAbove(std::max(here_, label), std::min(here_, label) + ring_[base].time);
  }

  Range rangeOf(const Crossing& c) const
  {
    const double a = ring_[c.base].slowness, b = ring_[c.target].slowness,
                 d = ring_[c.other].slowness;
    return {std::min(std::min(slowness_here_, a), std::min(b, d)),
            std::max(std::max(slowness_here_, a), std::max(b, d))};
  }

  /// Twice the area of the face.
  double area(std::size_t face) const { return std::sqrt(ring_[face].squared_area); }
  /// May the target get a lower label? No more can be told by the labels of the base alone: from a
  /// side of the face behind, a front may come that has not come to the ends of the base.
  bool mayLower(const Crossing& c) const
  {
    return mesh_map::mayLower(ring_[c.target].label, here_, ring_[c.base].label,
                              ring_[c.base].time);
  }

  bool areOpen(const Crossing& c) const
  {
    return !HAS_COSTS || (isIn(open_, c.target) && isIn(open_, c.other));
  }

  /// May the target follow from labels of that base, and behind it? They may not yet be what
  /// follows from each other.
  bool mayFollow(const Crossing& c, double label) const
  {
    return areOpen(c) &&
           (ring_[c.other].label < std::min(here_, ring_[c.base].label) ||
            mesh_map::mayLower(label, here_, ring_[c.base].label, ring_[c.base].time));
  }

  /// What comes there, if that may be below `label`.
  [[gnu::always_inline]] double across(const Crossing& c, double label) const
  {
    const double inverse = 1.0 / ring_[c.base].length;
    const Range range = HAS_COSTS ? rangeOf(c) : Range{1.0, 1.0};
    return FastMarchingCosts<HAS_COSTS>::front(
        here_, ring_[c.base].label,
        {ring_[c.base].length, ring_[c.face].product * inverse, area(c.face) * inverse,
         ring_[c.target].squared},
        {slowness_here_, ring_[c.base].slowness, ring_[c.target].slowness},
        {ring_[c.face_behind].product * inverse, area(c.face_behind) * inverse,
         ring_[c.other].label},
        range.low, range.high, label);
  }

  /// Lowers the label of the target, if that is so: its bit then, else none.
  std::uint64_t lower(const Crossing& c)
  {
    if (!mayLower(c) || !areOpen(c)) {
      return 0;
    }
    const double label = across(c, ring_[c.target].label);
    if (!step_.isAbove(ring_[c.target].label, label)) {
      return 0;
    }
    ring_[c.target].label = label;
    ring_[c.target].highest = std::max(std::max(here_, ring_[c.base].label), ring_[c.other].label);
    return bit(c.target, true);
  }

  FastMarchingStep step_;
  double here_, slowness_here_;
  bool is_closed_;
  std::size_t count_ = 0;
  std::uint64_t final_ = 0, open_ = 0;
  Neighbor ring_[SIZE];
};

}  // namespace mesh_map
