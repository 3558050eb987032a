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

  void prefetch(std::uint32_t v) const
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
/// share is computed once.
template <bool HAS_COSTS>
class FastMarchingRing
{
 public:
  /// A vertex of the ring.
  struct Neighbor
  {
    std::uint32_t vertex;
    Vector3 side;                                   // to it
    double squared, length, label, slowness, time;  // along the edge to it
    double highest;        // of the labels that a lowered one follows from; or see forEachFollowing
    double product, area;  // of its side and the next one; twice the area between
  };

  /// `to_come`: all that has a label above this one passes it on itself, later.
  FastMarchingRing(const FastMarchingMesh& mesh, const FastMarchingCosts<HAS_COSTS>& costs,
                   const double* labels, FastMarchingStep step, double to_come, std::uint32_t v)
      : step_(step),
        here_(labels[v]),
        to_come_(to_come),
        slowness_(costs.slowness(v)),
        is_closed_(mesh.isClosed(v))
  {
    const ArrayView<FastMarchingCorner> corners = mesh.corners(v);
    faces_ = corners.size();
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
      const Vector3 &side = ring_[i].side, &next = ring_[i + 1 < count_ ? i + 1 : 0].side;
      ring_[i].product = dot(side, next);
      ring_[i].area = norm(cross(side, next));  // of slivers, too, which lengths would not tell
    }
  }

  /// Along the edges, then across the faces.
  void lowerLabels()
  {
    for (std::size_t i = 0; i < count_; ++i) {
      if (isOpen(ring_[i])) {
        offer(ring_[i], here_ + ring_[i].time, here_);
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

  /// Calls visit(w) for each w whose label may be what comes along the edge, or across a face.
  template <class Visit>
  void forEachFollowing(const Visit& visit)
  {
    for (std::size_t i = 0; i < count_; ++i) {
      ring_[i].highest = ring_[i].label < NOT_REACHED ? mostOf(ring_[i].label) : -1.0;
      if (isOpen(ring_[i]) && here_ + ring_[i].time <= ring_[i].highest) {
        visit(ring_[i].vertex);
        ring_[i].highest = -1.0;
      }
    }
    const auto look = [&](std::size_t base, std::size_t target, std::size_t other,
                          const Neighbor& face, const Neighbor& face_behind) {
      Neighbor& t = ring_[target];
      if (t.highest >= 0.0 && mayFollow(base, target, other, t.highest) &&
          across(ring_[base], t, ring_[other], face, face_behind, t.highest) <= t.highest) {
        visit(t.vertex);
        t.highest = -1.0;
      }
    };
    for (std::size_t i = 0; i < faces_; ++i) {
      const std::size_t j = i + 1 < count_ ? i + 1 : 0;
      const std::size_t before = i > 0 ? i - 1 : is_closed_ ? count_ - 1 : NONE;
      const std::size_t after = j + 1 < count_ ? j + 1 : is_closed_ ? 0 : NONE;
      look(j, i, after, ring_[i], ring_[j]);
      look(i, j, before, ring_[i], ring_[before == NONE ? 0 : before]);
    }
  }

  /// What is up to this may be what a label follows from: small differences are left as they are.
  static double mostOf(double label) { return label * (1.0 + 10.0 * FastMarchingStep::PART); }

  const Neighbor* begin() const { return ring_; }
  const Neighbor* end() const { return ring_ + count_; }

  /// Calls visit(a, b) for the faces whose side opposite to the middle a front may cross that has
  /// been earlier in the middle than the labels of that side tell.
  template <class Visit>
  void forEachEarlier(const Visit& visit) const
  {
    for (std::size_t i = 0; i < faces_; ++i) {
      const Neighbor &a = ring_[i], &b = ring_[i + 1 < count_ ? i + 1 : 0];
      if (!isToCome(a) && !isToCome(b) && a.slowness == slowness_ && b.slowness == slowness_ &&
          slowness_ > 0.0) {
        const double scale = HAS_COSTS ? 1.0 / slowness_ : 1.0;
        if (mayBeEarlier(here_ * scale, a.label * scale, b.label * scale,
                         a.squared + b.squared - 2.0 * a.product, a.squared, a.squared - a.product,
                         a.area * a.area)) {
          visit(a.vertex, b.vertex);
        }
      }
    }
  }

 private:
  static constexpr std::size_t NONE = static_cast<std::size_t>(-1);

  /// Slowness at the corners of two faces.
  struct Range
  {
    double low, high;
  };

  bool isToCome(const Neighbor& n) const { return !(n.label <= to_come_ && n.label < NOT_REACHED); }
  static bool isOpen(const Neighbor& n) { return !HAS_COSTS || n.slowness < NOT_REACHED; }

  void offer(Neighbor& n, double label, double highest)
  {
    if (step_.isAbove(n.label, label)) {
      n.label = label;
      n.highest = highest;
    }
  }

  Range rangeOf(const Neighbor& a, const Neighbor& b, const Neighbor& c) const
  {
    return {std::min(std::min(slowness_, a.slowness), std::min(b.slowness, c.slowness)),
            std::max(std::max(slowness_, a.slowness), std::max(b.slowness, c.slowness))};
  }

  /// May the target get a lower label across the base from the middle to a neighbor? `other` is the
  /// third corner of the face on the other side. Where two labels differ by more than the time
  /// along the base, the higher one is about to become less, and then this is looked at again.
  bool mayLower(std::size_t base, std::size_t target, std::size_t other) const
  {
    const Neighbor& b = ring_[base];
    return isCrossed(base, target, other) &&
           mesh_map::mayLower(ring_[target].label, here_, b.label, b.time) &&
           !step_.isAbove(std::max(here_, b.label), std::min(here_, b.label) + b.time);
  }

  /// May the target follow from labels of that base, and behind it? They may not yet be what
  /// follows from each other.
  bool mayFollow(std::size_t base, std::size_t target, std::size_t other, double label) const
  {
    return isCrossed(base, target, other) &&
           (ring_[other].label < std::min(here_, ring_[base].label) ||
            mesh_map::mayLower(label, here_, ring_[base].label, ring_[base].time));
  }

  /// Does a front cross the base?
  bool isCrossed(std::size_t base, std::size_t target, std::size_t other) const
  {
    const Neighbor &b = ring_[base], &t = ring_[target];
    return !isToCome(b) && other != NONE && other != target && b.length > 0.0 &&
           (!HAS_COSTS || (isOpen(b) && isOpen(t) && isOpen(ring_[other])));
  }

  /// What comes there, if that may be below `label`. `face` and `face_behind` know the product and
  /// the area of the sides of the face of the target, and of that on the other side of the base.
  [[gnu::always_inline]] double across(const Neighbor& base, const Neighbor& target,
                                       const Neighbor& other, const Neighbor& face,
                                       const Neighbor& face_behind, double label) const
  {
    const double inverse = 1.0 / base.length;
    const Range range = HAS_COSTS ? rangeOf(base, target, other) : Range{1.0, 1.0};
    return FastMarchingCosts<HAS_COSTS>::front(
        here_, base.label,
        {base.length, face.product * inverse, face.area * inverse, target.squared},
        {slowness_, base.slowness, target.slowness},
        {face_behind.product * inverse, face_behind.area * inverse, other.label}, range.low,
        range.high, label);
  }

  /// Lowers the label of the target, if that is so.
  void lower(const Neighbor& base, Neighbor& target, const Neighbor& other, const Neighbor& face,
             const Neighbor& face_behind)
  {
    offer(target, across(base, target, other, face, face_behind, target.label),
          std::max(std::max(here_, base.label), other.label));
  }

  Neighbor ring_[FastMarchingMesh::MAX_FAN + 1];
  std::size_t faces_, count_;
  FastMarchingStep step_;
  double here_, to_come_, slowness_;
  bool is_closed_;
};

}  // namespace mesh_map
