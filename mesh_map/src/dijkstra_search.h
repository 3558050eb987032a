#ifndef MESH_MAP_SRC_DIJKSTRA_SEARCH_H
#define MESH_MAP_SRC_DIJKSTRA_SEARCH_H

#include <mesh_map/dijkstra.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "dijkstra_labels.h"
#include "dijkstra_queues.h"

namespace mesh_map {

/// Where a search may end.
struct DijkstraStop
{
  float limit;                         ///< known as soon as there is no target left
  std::vector<std::uint32_t> targets;  ///< not settled yet
  float offset = 0.0f;
  float farthest = 0.0f;  ///< of the targets that are settled

  /// Takes all targets off that are settled, and sets the limit with the last of them.
  template <class IsFinal>
  void settle(const DijkstraLabels& labels, const IsFinal& is_final)
  {
    if (targets.empty()) {
      return;
    }
    while (!targets.empty()) {
      const float distance = labels[targets.back()].distance;
      if (!(distance < std::numeric_limits<float>::infinity()) || !is_final(distance)) {
        return;
      }
      farthest = std::max(farthest, distance);
      targets.pop_back();
    }
    limit = std::min(limit, farthest + offset);
  }
};

enum class SearchEnd
{
  DONE,
  CANCELLED,
  OVERFLOWED  ///< the queue could not hold the search; another one has to go on
};

/// One search: grows the labels from what is in a queue, until all up to the limit are final.
class DijkstraSearch
{
 public:
  DijkstraSearch(const DijkstraGraph& graph, const VertexCosts& costs, DijkstraLabels& labels,
                 DijkstraStop& stop, const std::atomic<bool>* cancel)
      : graph_(graph), costs_(costs), labels_(labels), stop_(stop), cancel_(cancel)
  {
  }

  /// What is left is in the queue and in beyond() then. Even where it is cancelled from the start
  /// it gets somewhat farther, so that steps that are all broken off come to an end.
  template <class Queue>
  SearchEnd run(Queue& queue)
  {
    while (queue.nextBatch()) {
      stop_.settle(labels_, [&](float distance) { return queue.isFinal(distance); });
      if (queue.isPast(stop_.limit)) {
        return isCancelled() ? SearchEnd::CANCELLED : SearchEnd::DONE;
      }
      QueueEntry entry;
      while (queue.popFromBatch(entry)) {
        prefetch(queue);
        if (entry.distance == labels_[entry.vertex].distance) {
          expand(queue, entry);
        }
        if (++steps_ % STEPS_PER_CANCEL_CHECK == 0 && isCancelled()) {
          return SearchEnd::CANCELLED;
        }
      }
      if (queue.overflowed()) {
        return SearchEnd::OVERFLOWED;
      }
    }
    stop_.settle(labels_, [](float) { return true; });
    return isCancelled() ? SearchEnd::CANCELLED : SearchEnd::DONE;
  }

  /// Entries beyond the limit that were popped.
  std::vector<QueueEntry>& beyond() { return beyond_; }

  /// How many vertices' edges were gone over.
  std::size_t goneOver() const { return gone_over_; }

 private:
  static constexpr std::uint32_t STEPS_PER_CANCEL_CHECK = 1024;

  template <class Queue>
  void expand(Queue& queue, const QueueEntry& entry)
  {
    if (entry.distance > stop_.limit) {
      beyond_.push_back(entry);
      return;
    }
    ++gone_over_;
    const DijkstraGraph::Arc* const end = graph_.end(entry.vertex);
    for (const DijkstraGraph::Arc* arc = graph_.begin(entry.vertex); arc != end; ++arc) {
      const float distance = entry.distance + arc->weight;
      DijkstraLabel& label = labels_[arc->to];
      if (distance < label.distance) {
        if (label.distance == std::numeric_limits<float>::infinity()) {
          if (!costs_.isPassable(arc->to)) {
            continue;
          }
          if (label.from == NO_INDEX) {
            labels_.touch(arc->to);
          }
        }
        label = {distance, entry.vertex};
        queue.push(distance, arc->to);
      }
    }
  }

  /// Asks for the memory of entries that come soon: most of the time would go into waiting for it.
  template <class Queue>
  void prefetch(const Queue& queue) const
  {
    constexpr std::size_t soon = 6, later = 16;
    if (const QueueEntry* entry = queue.peek(later)) {
      __builtin_prefetch(graph_.offset(entry->vertex));
      __builtin_prefetch(&labels_[entry->vertex]);
    }
    const QueueEntry* entry = queue.peek(soon);
    if (entry != nullptr && entry->distance == labels_[entry->vertex].distance) {
      __builtin_prefetch(graph_.begin(entry->vertex));
      __builtin_prefetch(graph_.end(entry->vertex));
    }
  }

  bool isCancelled() const
  {
    return cancel_ != nullptr && cancel_->load(std::memory_order_relaxed);
  }

  const DijkstraGraph& graph_;
  const VertexCosts costs_;
  DijkstraLabels& labels_;
  DijkstraStop& stop_;
  const std::atomic<bool>* cancel_;
  std::vector<QueueEntry> beyond_;
  std::size_t gone_over_ = 0;
  std::uint32_t steps_ = 0;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_DIJKSTRA_SEARCH_H
