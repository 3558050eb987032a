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
#include "distance/fast_marching/fast_marching_ranks.h"
#include "distance/fast_marching/fast_marching_ring.h"
#include "distance/fast_marching/fast_marching_triangle.h"
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
  FastMarchingRanks ranks;              // of labels that are repaired

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

/// What the label of a vertex should be by those around it.
struct FastMarchingPull
{
  double label = NOT_REACHED;       ///< infinite for a closed one
  double highest = 0.0;             ///< of the ranks that it follows from
  double least_step = NOT_REACHED;  ///< the least time along an edge to it
};

/// How labels of neighbors follow from each other.
template <bool HAS_COSTS>
class FastMarchingUpdate
{
 public:
  /// What is called for lowered labels where nobody wants to know.
  struct NoMatter
  {
    void operator()(std::uint32_t, double, double) const {}
  };

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

  void push(std::uint32_t v) { push(v, NoMatter()); }

  /// Lowers labels around v, as follows from its own. Calls lowered(w, before, highest) for each w
  /// that had the label `before`: what it has now follows from ranks up to `highest`, or less.
  template <class Lowered>
  void push(std::uint32_t v, const Lowered& lowered)
  {
    if (mesh_.isFan(v)) {
      const double to_come = buffers_.is_in_repair ? NOT_REACHED : buffers_.queue.ceiling();
      FastMarchingRing<HAS_COSTS> ring(mesh_, costs_, labels_, step_, to_come, v);
      const double highest = highestRank(ring, v);
      ring.lowerLabels([&](std::size_t i) {
        offer(ring.vertex(i), ring.label(i), std::max(ring.highest(i), highest), lowered);
      });
      ring.forEachEarlier([&](std::uint32_t a, std::uint32_t b) { offerAcross(v, a, b, lowered); });
      return;
    }
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      if (c.a == v) {
        continue;
      }
      offerAlongEdge(v, c.a, lowered);
      offerAlongEdge(v, c.b, lowered);
      if (c.a != c.b && isOpen(c.a) && isOpen(c.b)) {
        offer(c.a, across(v, c.b, c.a, labels_[c.a]), NOT_REACHED, lowered);
        offer(c.b, across(v, c.a, c.b, labels_[c.b]), NOT_REACHED, lowered);
      }
    }
    forEachSeen(v, labels_[v], [&](std::uint32_t, const FastMarchingCorner& c) {
      offerAcross(v, c.a, c.b, lowered);
    });
  }

  /// Calls visit(w) for each w whose label may follow from that of v, some more than once.
  template <class Visit>
  void forEachFollowing(std::uint32_t v, const Visit& visit) const
  {
    if (!mesh_.isFan(v)) {
      for (const FastMarchingCorner& c : mesh_.corners(v)) {
        visit(c.a);
        visit(c.b);
      }
      forEachSeen(v, labels_[v],
                  [&](std::uint32_t seen, const FastMarchingCorner&) { visit(seen); });
      return;
    }
    FastMarchingRing<HAS_COSTS> ring(mesh_, costs_, labels_, step_, NOT_REACHED, v);
    ring.forEachFollowing(visit);
    ring.forEachEarlier([&](std::uint32_t a, std::uint32_t b) {
      const std::uint32_t seen = mesh_.across(a, b, v);
      if (seen != NO_INDEX && labels_[seen] < NOT_REACHED) {
        if (across(a, b, seen, NOT_REACHED) <= ring.mostOf(labels_[seen])) {
          visit(seen);
        }
      }
    });
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

  /// What the label of v should be by those around it whose ranks are below `below`.
  FastMarchingPull pull(std::uint32_t v, double below = NOT_REACHED) const
  {
    FastMarchingPull best;
    if (!isOpen(v)) {
      return best;
    }
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      if (c.a == v) {
        continue;
      }
      for (const std::uint32_t from : {c.a, c.b}) {
        if (from != v && isBelow(from, below) && isOpen(from)) {
          const double step = costs_.alongEdge(from, v, length(from, v));
          best.least_step = std::min(best.least_step, step);
          if (labels_[from] + step < best.label) {
            best.label = labels_[from] + step;
            best.highest = rank(from);
          }
        }
      }
    }
    for (const FastMarchingCorner& c : mesh_.corners(v)) {
      if (c.a != v && c.a != c.b && isOpen(c.a) && isOpen(c.b)) {
        pullAcross(c.a, c.b, v, below, best);
      }
    }
    return best;
  }

  double rank(std::uint32_t v) const { return buffers_.ranks.of(v, labels_[v]); }

  /// The highest rank of what v may follow from.
  double highestAround(std::uint32_t v) const
  {
    double highest = 0.0;
    const auto look = [&](std::uint32_t other) {
      if (other != v && other != NO_INDEX && labels_[other] < NOT_REACHED) {
        highest = std::max(highest, rank(other));
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

  void offer(std::uint32_t v, double label) { offer(v, label, NOT_REACHED, NoMatter()); }

  template <class Lowered>
  void offer(std::uint32_t v, double label, double highest, const Lowered& lowered)
  {
    const double last = labels_[v];
    if (isAbove(last, label)) {
      if (last == NOT_REACHED) {
        buffers_.touched.push_back(v);
      }
      labels_[v] = label;
      buffers_.queueLowered(label, v);
      lowered(v, last, highest);
    }
  }

  /// Asks for the memory of entries that come soon. Always inlined, as what it calls: the compiler
  /// takes a function of which only this remains for one that does nothing, and drops the calls.
  [[gnu::always_inline]] void prefetch() const
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
    const auto* const soon = queue.peek(3);
    if (soon != nullptr && soon->label == labels_[soon->vertex]) {  // half of all are stale
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

  template <class Lowered>
  void offerAlongEdge(std::uint32_t from, std::uint32_t to, const Lowered& lowered)
  {
    if (to != from && isOpen(to)) {
      offer(to, labels_[from] + costs_.alongEdge(from, to, length(from, to)), NOT_REACHED, lowered);
    }
  }

  /// To what lies on the other side of the edge (a, b) of a face of v.
  template <class Lowered>
  void offerAcross(std::uint32_t v, std::uint32_t a, std::uint32_t b, const Lowered& lowered)
  {
    const std::uint32_t target = mesh_.across(a, b, v);
    if (target != NO_INDEX && isOpen(target)) {
      offer(target, across(a, b, target, labels_[target]), NOT_REACHED, lowered);
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

  bool isBelow(std::uint32_t v, double below) const
  {
    return below < NOT_REACHED ? rank(v) < below && labels_[v] < NOT_REACHED
                               : labels_[v] < NOT_REACHED;
  }

  /// Of those that are not what labels tell; 0 where none of them is above the label of v.
  double highestRank(const FastMarchingRing<HAS_COSTS>& ring, std::uint32_t v) const
  {
    if (buffers_.ranks.areLabelsFrom(labels_[v])) {
      return 0.0;
    }
    double highest = 0.0;
    const auto look = [&](std::uint32_t vertex) {
      const double found = rank(vertex);
      highest = found > labels_[vertex] ? std::max(highest, found) : highest;
    };
    look(v);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      look(ring.vertex(i));
    }
    return highest;
  }

  /// What comes to v across the base from a to b by ranks below `below`. That of the third corner
  /// of the face behind counts as what it follows from only where it would be more without.
  void pullAcross(std::uint32_t a, std::uint32_t b, std::uint32_t v, double below,
                  FastMarchingPull& best) const
  {
    std::uint32_t other = NO_INDEX;
    const double label = across(a, b, v, best.label, below, &other);
    if (!(label < best.label)) {
      return;
    }
    double highest = std::max(rank(a), rank(b));
    if (other != a && isBelow(other, below)) {
      const double behind = rank(other);
      if (behind > highest && !(behind >= label && across(a, b, v, best.label, behind) <= label)) {
        highest = behind;
      }
    }
    best.label = label;
    best.highest = highest;
  }

  /// What comes to `target` across the base from a to b by ranks below `below`, if that may be
  /// less than `label`. `third` becomes what findOther() tells.
  double across(std::uint32_t a, std::uint32_t b, std::uint32_t target, double label,
                double below = NOT_REACHED, std::uint32_t* third = nullptr) const
  {
    const double u = labels_[a], v = labels_[b];
    if (!(isBelow(a, below) && isBelow(b, below))) {
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
    if (third != nullptr) {
      *third = other;
    }
    if (other == NO_INDEX) {
      return NOT_REACHED;
    }
    const Vector3 side = between(mesh_.position(a), mesh_.position(target));
    const double inverse = 1.0 / length;
    FastMarchingBehind behind = {0.0, 0.0, NOT_REACHED};
    if (other != a) {
      const Vector3 back = between(mesh_.position(a), mesh_.position(other));
      behind = {dot(base, back) * inverse, norm(cross(base, back)) * inverse,
                isBelow(other, below) ? labels_[other] : NOT_REACHED};
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
