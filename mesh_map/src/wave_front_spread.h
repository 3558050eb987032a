#ifndef MESH_MAP_SRC_WAVE_FRONT_SPREAD_H
#define MESH_MAP_SRC_WAVE_FRONT_SPREAD_H

#include <mesh_map/front_mesh.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "wave_front_buffers.h"
#include "wave_front_costs.h"
#include "wave_front_ring.h"

namespace mesh_map {

/// How labels of neighbors follow from each other.
template <bool HAS_COSTS>
class WaveFrontSpread
{
 public:
  WaveFrontSpread(const FrontMesh& mesh, WaveFrontBuffers& buffers, ArrayView<float> slowness)
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
      WaveFrontRing<HAS_COSTS> ring(mesh_, costs_, labels_, step_, v);
      ring.lowerLabels();
      for (const auto& neighbor : ring) {
        offer(neighbor.vertex, neighbor.label);
      }
      return;
    }
    for (const FrontCorner* c = mesh_.cornersBegin(v); c != mesh_.cornersEnd(v); ++c) {
      if (c->a == v) {
        continue;
      }
      offerAlongEdge(v, c->a);
      offerAlongEdge(v, c->b);
      if (c->a != c->b && isOpen(c->a) && isOpen(c->b)) {
        offer(c->a, across(v, c->b, c->a, labels_[c->a]));
        offer(c->b, across(v, c->a, c->b, labels_[c->b]));
      }
    }
  }

  /// What the label of v should be by those around it; infinite for a closed one. `least_step`
  /// becomes the least time along an edge to v.
  double pull(std::uint32_t v, double& least_step) const
  {
    double best = NOT_REACHED;
    least_step = NOT_REACHED;
    if (!isOpen(v)) {
      return best;
    }
    for (const FrontCorner* c = mesh_.cornersBegin(v); c != mesh_.cornersEnd(v); ++c) {
      if (c->a == v) {
        continue;
      }
      for (const std::uint32_t from : {c->a, c->b}) {
        if (from != v && labels_[from] < NOT_REACHED && isOpen(from)) {
          const double step = costs_.alongEdge(from, v, length(from, v));
          least_step = std::min(least_step, step);
          best = std::min(best, labels_[from] + step);
        }
      }
    }
    for (const FrontCorner* c = mesh_.cornersBegin(v); c != mesh_.cornersEnd(v); ++c) {
      if (c->a != v && c->a != c->b && isOpen(c->a) && isOpen(c->b)) {
        best = std::min(best, across(c->a, c->b, v, best));
      }
    }
    return best;
  }

  /// A label that nothing which is still to come from v goes below.
  double leastAround(std::uint32_t v) const
  {
    double least = labels_[v];
    for (const FrontCorner* c = mesh_.cornersBegin(v); c != mesh_.cornersEnd(v); ++c) {
      for (const std::uint32_t other : {c->a, c->b}) {
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
    const WaveFrontQueue& queue = buffers_.queue;
    if (const std::uint32_t v = queue.peek(12); v != NO_INDEX) {
      mesh_.prefetchRow(v);
      mesh_.prefetchVertex(v);
      __builtin_prefetch(&labels_[v]);
    }
    if (const std::uint32_t v = queue.peek(7); v != NO_INDEX) {
      mesh_.prefetchCorners(v);
    }
    if (const std::uint32_t v = queue.peek(3); v != NO_INDEX) {
      for (const FrontCorner* c = mesh_.cornersBegin(v); c != mesh_.cornersEnd(v); ++c) {
        mesh_.prefetchVertex(c->a);
        __builtin_prefetch(&labels_[c->a]);
        costs_.prefetch(c->a);
      }
    }
  }

 private:
  double length(std::uint32_t a, std::uint32_t b) const
  {
    const WaveFrontVector side = between(mesh_.position(a), mesh_.position(b));
    return std::sqrt(dot(side, side));
  }

  void offerAlongEdge(std::uint32_t from, std::uint32_t to)
  {
    if (to != from && isOpen(to)) {
      offer(to, labels_[from] + costs_.alongEdge(from, to, length(from, to)));
    }
  }

  /// What comes to `target` across the base from a to b, if that may be less than `label`.
  double across(std::uint32_t a, std::uint32_t b, std::uint32_t target, double label) const
  {
    const double u = labels_[a], v = labels_[b];
    if (!(u < NOT_REACHED && v < NOT_REACHED)) {
      return NOT_REACHED;
    }
    const WaveFrontVector base = between(mesh_.position(a), mesh_.position(b));
    const double length = std::sqrt(dot(base, base));
    double low = std::min({costs_.slowness(a), costs_.slowness(b), costs_.slowness(target)});
    double high = std::max({costs_.slowness(a), costs_.slowness(b), costs_.slowness(target)});
    if (!(length > 0.0) || !mesh_map::mayLower(label, u, v, costs_.alongEdge(a, b, length))) {
      return NOT_REACHED;
    }
    const std::uint32_t other = findOther(a, b, target, low, high);
    if (other == NO_INDEX) {
      return NOT_REACHED;
    }
    const WaveFrontVector side = between(mesh_.position(a), mesh_.position(target));
    const double inverse = 1.0 / length;
    WaveFrontBehind behind = {0.0, 0.0, NOT_REACHED};
    if (other != a) {
      const WaveFrontVector back = between(mesh_.position(a), mesh_.position(other));
      behind = {dot(base, back) * inverse, crossLength(base, back) * inverse, labels_[other]};
    }
    return WaveFrontCosts<HAS_COSTS>::front(
        u, v,
        {length, dot(base, side) * inverse, crossLength(base, side) * inverse, dot(side, side)},
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
    for (const FrontCorner* c = mesh_.cornersBegin(a); c != mesh_.cornersEnd(a); ++c) {
      if (c->a != c->b && (c->a == b || c->b == b)) {
        const std::uint32_t third = c->a == b ? c->b : c->a;
        if (third != target && third != a && isOpen(third)) {
          found = found == NO_INDEX ? third : a;
          low = std::min(low, costs_.slowness(third));
          high = std::max(high, costs_.slowness(third));
        }
      }
    }
    return found;
  }

  const FrontMesh& mesh_;
  WaveFrontBuffers& buffers_;
  double* labels_;
  WaveFrontCosts<HAS_COSTS> costs_;
  WaveFrontStep step_;
};

/// Labels up to this one will not be lowered any more by what is in the queue.
template <bool HAS_COSTS>
double finalLimit(const FrontMesh& mesh, WaveFrontBuffers& buffers, ArrayView<float> slowness)
{
  const WaveFrontSpread<HAS_COSTS> spread(mesh, buffers, slowness);
  double limit = NOT_REACHED;
  buffers.queue.forEach([&](const WaveFrontEntry& entry) {
    if (entry.label == buffers.labels[entry.vertex]) {
      limit = std::min(limit, spread.leastAround(entry.vertex));
    }
  });
  return limit;
}

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_WAVE_FRONT_SPREAD_H
