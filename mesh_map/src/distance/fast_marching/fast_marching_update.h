#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "base/bucket_queue.h"
#include "distance/fast_marching/fast_marching_behind.h"
#include "distance/fast_marching/fast_marching_triangle.h"
#include "distance/fast_marching/fast_marching_uneven.h"
#include "mesh/packed_position.h"

namespace mesh_map {

/// What a repair has to do at a vertex, once all that is nearer than `key` is as it should be.
struct FastMarchingTask
{
  enum Kind : std::uint32_t
  {
    PROPAGATE,  ///< it has the label `key` now: tell its neighbors
    CHECK,      ///< it has the label `key`: does that still follow from its neighbors?
    SETTLE,     ///< it will have this one by its neighbors
    WAIT        ///< it will have a lower one, if all around up to `key` stays as it is
  };

  double key;
  std::uint32_t vertex;
  Kind kind;

  bool operator>(const FastMarchingTask& other) const
  {
    return std::tie(key, vertex, kind) > std::tie(other.key, other.vertex, other.kind);
  }
};

/// What a front needs while it lives.
struct FastMarchingBuffers
{
  LargeArray<double> labels;           // infinite where not reached
  std::vector<std::uint32_t> touched;  // all vertices that had a label once
  BucketQueue<double> queue;
  bool is_in_repair = false;            // then labels that are lowered become tasks
  std::vector<FastMarchingTask> tasks;  // a heap, the nearest first

  /// Everything as in new ones. Takes as long as what was touched is large.
  void clear();

  /// A vertex has got a lower label.
  void queueLowered(double label, std::uint32_t vertex)
  {
    if (is_in_repair) {
      addTask({label, vertex, FastMarchingTask::PROPAGATE});
    } else {
      queue.push(label, vertex);
    }
  }

  void addTask(const FastMarchingTask& task)
  {
    tasks.push_back(task);
    std::push_heap(tasks.begin(), tasks.end(), std::greater<FastMarchingTask>());
  }

  FastMarchingTask takeTask()
  {
    std::pop_heap(tasks.begin(), tasks.end(), std::greater<FastMarchingTask>());
    const FastMarchingTask task = tasks.back();
    tasks.pop_back();
    return task;
  }
};

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
  /// third corner of the face on the other side. Where two labels differ by more than the time
  /// along the base, the higher one is about to become less, and then this is looked at again.
  bool mayLower(std::size_t base, std::size_t target, std::size_t other) const
  {
    const Neighbor &b = ring_[base], &t = ring_[target];
    if (isToCome(b) || other == NONE || other == target || !(b.length > 0.0)) {
      return false;
    }
    return mesh_map::mayLower(t.label, here_, b.label, b.time) &&
           !step_.isAbove(std::max(here_, b.label), std::min(here_, b.label) + b.time) &&
           (!HAS_COSTS || (isOpen(b) && isOpen(t) && isOpen(ring_[other])));
  }

  /// Lowers it, if that is so. `face` and `face_behind` know the product and the area of the sides
  /// of the face of the target, and of that on the other side of the base.
  void lower(const Neighbor& base, Neighbor& target, const Neighbor& other, const Neighbor& face,
             const Neighbor& face_behind)
  {
    const double inverse = 1.0 / base.length;
    const Range range = HAS_COSTS ? rangeOf(base, target, other) : Range{1.0, 1.0};
    offer(target, FastMarchingCosts<HAS_COSTS>::front(
                      here_, base.label,
                      {base.length, face.product * inverse, face.area * inverse, target.squared},
                      {slowness_, base.slowness, target.slowness},
                      {face_behind.product * inverse, face_behind.area * inverse, other.label},
                      range.low, range.high, target.label));
  }

  Neighbor ring_[FastMarchingMesh::MAX_FAN + 1];
  std::size_t faces_, count_;
  FastMarchingStep step_;
  double here_, to_come_, slowness_;
  bool is_closed_;
};

/// How labels of neighbors follow from each other.
template <bool HAS_COSTS>
class FastMarchingUpdate
{
 public:
  FastMarchingUpdate(const FastMarchingMesh& mesh, FastMarchingBuffers& buffers,
                     ArrayView<float> slowness)
      : mesh_(mesh),
        buffers_(buffers),
        labels_(buffers.labels.data()),
        costs_(slowness),
        step_{1e-12 * buffers.queue.width()}
  {
  }

  bool isOpen(std::uint32_t v) const { return costs_.isOpen(v); }

  /// Is a label higher than another one, by more than what is left as it is?
  bool isAbove(double label, double other) const { return step_.isAbove(label, other); }

  /// Lowers labels around v, as follows from its own.
  void push(std::uint32_t v)
  {
    if (mesh_.isFan(v)) {
      const double to_come = buffers_.is_in_repair ? NOT_REACHED : buffers_.queue.ceiling();
      FastMarchingRing<HAS_COSTS> ring(mesh_, costs_, labels_, step_, to_come, v);
      ring.lowerLabels();
      for (const auto& neighbor : ring) {
        offer(neighbor.vertex, neighbor.label);
      }
      ring.forEachEarlier([&](std::uint32_t a, std::uint32_t b) { offerAcross(v, a, b); });
      return;
    }
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      if (c.a == v) {
        continue;
      }
      offerAlongEdge(v, c.a);
      offerAlongEdge(v, c.b);
      if (c.a != c.b && isOpen(c.a) && isOpen(c.b)) {
        offer(c.a, across(v, c.b, c.a, labels_[c.a]));
        offer(c.b, across(v, c.a, c.b, labels_[c.b]));
      }
    }
    forEachSeen(v, labels_[v],
                [&](std::uint32_t, const FastMarchingCorner& c) { offerAcross(v, c.a, c.b); });
  }

  /// Calls visit(w, corner) for each w whose label may follow from `label` at v without an edge
  /// between them: across that corner of v, in whose face the front has been earlier at v than the
  /// labels of its other ends tell.
  template <class Visit>
  void forEachSeen(std::uint32_t v, double label, const Visit& visit) const
  {
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      if (c.a != v && c.a != c.b && mayBeSeen(v, label, c.a, c.b)) {
        const std::uint32_t seen = mesh_.across(c.a, c.b, v);
        if (seen != NO_INDEX) {
          visit(seen, c);
        }
      }
    }
  }

  /// What the label of v should be by those around it that are below `below`; infinite for a closed
  /// one. `least_step` becomes the least time along an edge to v.
  double pull(std::uint32_t v, double below, double& least_step) const
  {
    double best = NOT_REACHED;
    least_step = NOT_REACHED;
    if (!isOpen(v)) {
      return best;
    }
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      if (c.a == v) {
        continue;
      }
      for (const std::uint32_t from : {c.a, c.b}) {
        if (from != v && labels_[from] < below && isOpen(from)) {
          const double step = costs_.alongEdge(from, v, length(from, v));
          least_step = std::min(least_step, step);
          best = std::min(best, labels_[from] + step);
        }
      }
    }
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      if (c.a != v && c.a != c.b && isOpen(c.a) && isOpen(c.b)) {
        best = std::min(best, across(c.a, c.b, v, best, below));
      }
    }
    return best;
  }

  /// The highest label that the one of v may follow from.
  double highestAround(std::uint32_t v) const
  {
    double highest = 0.0;
    const auto look = [&](std::uint32_t other) {
      if (other != v && other != NO_INDEX && labels_[other] < NOT_REACHED) {
        highest = std::max(highest, labels_[other]);
      }
    };
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      look(c.a);
      look(c.b);
      look(c.a != c.b && c.a != v ? mesh_.across(c.a, c.b, v) : NO_INDEX);
    }
    return highest;
  }

  /// A label that nothing which is still to come from v goes below.
  double leastAround(std::uint32_t v) const
  {
    double least = labels_[v];
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      for (const std::uint32_t other : {c.a, c.b}) {
        if (other != v && labels_[other] < NOT_REACHED && isOpen(other)) {
          const double base = costs_.alongEdge(v, other, length(v, other));
          least = std::min(least, leastOnBase(labels_[v], labels_[other], base));
        }
      }
    }
    return least;
  }

  void offer(std::uint32_t v, double label)
  {
    const double last = labels_[v];
    if (isAbove(last, label)) {
      if (last == NOT_REACHED) {
        buffers_.touched.push_back(v);
      }
      labels_[v] = label;
      buffers_.queueLowered(label, v);
    }
  }

  void prefetch() const
  {
    const BucketQueue<double>& queue = buffers_.queue;
    if (const auto* const latest = queue.peek(12)) {
      mesh_.prefetchRow(latest->vertex);
      mesh_.prefetchVertex(latest->vertex);
      __builtin_prefetch(&labels_[latest->vertex]);
    }
    if (const auto* const later = queue.peek(7)) {
      mesh_.prefetchCorners(later->vertex);
    }
    if (const auto* const soon = queue.peek(3)) {
      for (const FastMarchingCorner& c : mesh_.corners(soon->vertex)) {
        mesh_.prefetchVertex(c.a);
        __builtin_prefetch(&labels_[c.a]);
        costs_.prefetch(c.a);
      }
    }
  }

 private:
  double length(std::uint32_t a, std::uint32_t b) const
  {
    return norm(between(mesh_.position(a), mesh_.position(b)));
  }

  void offerAlongEdge(std::uint32_t from, std::uint32_t to)
  {
    if (to != from && isOpen(to)) {
      offer(to, labels_[from] + costs_.alongEdge(from, to, length(from, to)));
    }
  }

  /// To what lies on the other side of the edge (a, b) of a face of v.
  void offerAcross(std::uint32_t v, std::uint32_t a, std::uint32_t b)
  {
    const std::uint32_t target = mesh_.across(a, b, v);
    if (target != NO_INDEX && isOpen(target)) {
      offer(target, across(a, b, target, labels_[target]));
    }
  }

  bool mayBeSeen(std::uint32_t v, double label, std::uint32_t a, std::uint32_t b) const
  {
    const double slowness = costs_.slowness(v);
    if (!(labels_[a] < NOT_REACHED && labels_[b] < NOT_REACHED) || !(slowness > 0.0) ||
        costs_.slowness(a) != slowness || costs_.slowness(b) != slowness) {
      return false;
    }
    const Vector3 base = between(mesh_.position(a), mesh_.position(b));
    const Vector3 side = between(mesh_.position(a), mesh_.position(v)), normal = cross(base, side);
    return mayBeEarlier(label / slowness, labels_[a] / slowness, labels_[b] / slowness,
                        dot(base, base), dot(side, side), dot(base, side), dot(normal, normal));
  }

  /// What comes to `target` across the base from a to b by labels below `below`, if that may be
  /// less than `label`.
  double across(std::uint32_t a, std::uint32_t b, std::uint32_t target, double label,
                double below = NOT_REACHED) const
  {
    const double u = labels_[a], v = labels_[b];
    if (!(u < below && v < below)) {
      return NOT_REACHED;
    }
    const Vector3 base = between(mesh_.position(a), mesh_.position(b));
    const double length = norm(base);
    double low = std::min({costs_.slowness(a), costs_.slowness(b), costs_.slowness(target)});
    double high = std::max({costs_.slowness(a), costs_.slowness(b), costs_.slowness(target)});
    if (!(length > 0.0) || !mesh_map::mayLower(label, u, v, costs_.alongEdge(a, b, length))) {
      return NOT_REACHED;
    }
    const std::uint32_t other = findOther(a, b, target, low, high);
    if (other == NO_INDEX) {
      return NOT_REACHED;
    }
    const Vector3 side = between(mesh_.position(a), mesh_.position(target));
    const double inverse = 1.0 / length;
    FastMarchingBehind behind = {0.0, 0.0, NOT_REACHED};
    if (other != a) {
      const Vector3 back = between(mesh_.position(a), mesh_.position(other));
      behind = {dot(base, back) * inverse, norm(cross(base, back)) * inverse,
                labels_[other] < below ? labels_[other] : NOT_REACHED};
    }
    return FastMarchingCosts<HAS_COSTS>::front(
        u, v,
        {length, dot(base, side) * inverse, norm(cross(base, side)) * inverse, dot(side, side)},
        {costs_.slowness(a), costs_.slowness(b), costs_.slowness(target)}, behind, low, high,
        label);
  }

  /// The third corner of the other open face at the edge (a, b), from which a front may come; a
  /// where there are several, NO_INDEX for none. The lowest and the highest slowness become those
  /// of their corners, too.
  std::uint32_t findOther(std::uint32_t a, std::uint32_t b, std::uint32_t target, double& low,
                          double& high) const
  {
    std::uint32_t found = NO_INDEX;
    for (const FastMarchingCorner& c : mesh_.corners(a)) {
      if (c.a != c.b && (c.a == b || c.b == b)) {
        const std::uint32_t third = c.a == b ? c.b : c.a;
        if (third != target && third != a && isOpen(third)) {
          found = found == NO_INDEX ? third : a;
          low = std::min(low, costs_.slowness(third));
          high = std::max(high, costs_.slowness(third));
        }
      }
    }
    return found;
  }

  const FastMarchingMesh& mesh_;
  FastMarchingBuffers& buffers_;
  double* labels_;
  FastMarchingCosts<HAS_COSTS> costs_;
  FastMarchingStep step_;
};

/// Labels up to this one will not be lowered any more by what is in the queue.
template <bool HAS_COSTS>
double finalLimit(const FastMarchingMesh& mesh, FastMarchingBuffers& buffers,
                  ArrayView<float> slowness)
{
  const FastMarchingUpdate<HAS_COSTS> update(mesh, buffers, slowness);
  double limit = NOT_REACHED;
  buffers.queue.forEach([&](const QueueEntry<double>& entry) {
    if (entry.label == buffers.labels[entry.vertex]) {
      limit = std::min(limit, update.leastAround(entry.vertex));
    }
  });
  return limit;
}

}  // namespace mesh_map
