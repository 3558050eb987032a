#include <mesh_map/dijkstra.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "dijkstra_queues.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

/// Stands in the potential for a vertex that is never passed: no distance is less.
constexpr float BLOCKED = -1.0f;

constexpr std::uint32_t STEPS_PER_CANCEL_CHECK = 1024;

void require(bool condition, const std::string& message)
{
  if (!condition) {
    throw std::invalid_argument(message);
  }
}

/// NaN fails the first comparison, +inf the second.
bool isPassable(float cost, float limit)
{
  return cost <= limit && cost < INFINITE;
}

}  // namespace

/// One search: the labels while they grow.
class DijkstraGraph::Run
{
 public:
  Run(const DijkstraGraph& graph, const DijkstraQuery& query)
      : graph_(graph),
        query_(query),
        targets_(query.targets.begin(), query.targets.end()),
        potential_(graph.vertexCount(), INFINITE),
        predecessors_(graph.vertexCount())
  {
    std::iota(predecessors_.begin(), predecessors_.end(), 0u);
    for (std::size_t v = 0; v < query.vertex_costs.size(); ++v) {
      if (!isPassable(query.vertex_costs[v], query.cost_limit)) {
        potential_[v] = BLOCKED;
      }
    }
  }

  /// False where the queue could not hold the search; then the labels are of no use.
  template <class Queue>
  bool search(Queue& queue)
  {
    if (isCancelled()) {
      return true;
    }
    if (!query_.sources.empty()) {
      queue.start(
          *std::min_element(query_.source_distances.begin(), query_.source_distances.end()));
    }
    for (std::size_t i = 0; i < query_.sources.size(); ++i) {
      label(queue, query_.sources[i], query_.source_distances[i], query_.sources[i]);
    }
    while (queue.nextBatch()) {
      if (!targets_.empty()) {
        settleTargets(queue);
      }
      if (queue.isPast(limit_)) {
        break;
      }
      QueueEntry entry;
      while (queue.popFromBatch(entry)) {
        prefetch(queue);
        if (entry.distance == potential_[entry.vertex]) {
          expand(queue, entry);
        }
        if (++steps_ % STEPS_PER_CANCEL_CHECK == 0 && isCancelled()) {
          return true;
        }
      }
      if (queue.overflowed()) {
        return false;
      }
    }
    forgetBeyondLimit();
    cancelled_ = isCancelled();
    return true;
  }

  DijkstraField takeField()
  {
    if (!query_.vertex_costs.empty()) {
      std::replace(potential_.begin(), potential_.end(), BLOCKED, INFINITE);
    }
    return {std::move(potential_), std::move(predecessors_), cancelled_};
  }

 private:
  template <class Queue>
  void label(Queue& queue, std::uint32_t vertex, float distance, std::uint32_t from)
  {
    if (distance < potential_[vertex] && distance <= limit_) {
      potential_[vertex] = distance;
      predecessors_[vertex] = from;
      queue.push(distance, vertex);
    }
  }

  /// Asks for the memory of entries that come soon: most of the time would go into waiting for it.
  template <class Queue>
  void prefetch(const Queue& queue) const
  {
    constexpr std::size_t soon = 6, later = 16;
    if (const QueueEntry* entry = queue.peek(later)) {
      __builtin_prefetch(&graph_.offsets_[entry->vertex]);
      __builtin_prefetch(&potential_[entry->vertex]);
    }
    const QueueEntry* entry = queue.peek(soon);
    if (entry != nullptr && entry->distance == potential_[entry->vertex]) {
      __builtin_prefetch(graph_.arcs_.data() + graph_.offsets_[entry->vertex]);
      __builtin_prefetch(graph_.arcs_.data() + graph_.offsets_[entry->vertex + 1]);
    }
  }

  template <class Queue>
  void expand(Queue& queue, const QueueEntry& entry)
  {
    if (entry.distance > limit_) {
      return;
    }
    const Arc* const end = graph_.arcs_.data() + graph_.offsets_[entry.vertex + 1];
    for (const Arc* arc = graph_.arcs_.data() + graph_.offsets_[entry.vertex]; arc != end; ++arc) {
      label(queue, arc->to, entry.distance + arc->weight, entry.vertex);
    }
  }

  /// Sets the limit as soon as the distances of all targets are known.
  template <class Queue>
  void settleTargets(const Queue& queue)
  {
    while (!targets_.empty()) {
      const float distance = potential_[targets_.back()];
      if (distance == BLOCKED || !queue.isFinal(distance)) {
        return;
      }
      farthest_target_ = std::max(farthest_target_, distance);
      targets_.pop_back();
    }
    limit_ = farthest_target_ + query_.offset;
  }

  /// Beyond the limit there are labels that are not final, and some that are: all count as not
  /// reached.
  void forgetBeyondLimit()
  {
    for (std::uint32_t v = 0; limit_ < INFINITE && v < potential_.size(); ++v) {
      if (potential_[v] > limit_) {
        potential_[v] = INFINITE;
        predecessors_[v] = v;
      }
    }
  }

  bool isCancelled()
  {
    cancelled_ = query_.cancel != nullptr && query_.cancel->load(std::memory_order_relaxed);
    return cancelled_;
  }

  const DijkstraGraph& graph_;
  const DijkstraQuery& query_;
  std::vector<std::uint32_t> targets_;  // not settled yet
  std::vector<float> potential_;
  std::vector<std::uint32_t> predecessors_;
  float limit_ = INFINITE;
  float farthest_target_ = 0.0f;
  std::uint32_t steps_ = 0;
  bool cancelled_ = false;
};

DijkstraGraph::DijkstraGraph(const RowsView& neighbors, ArrayView<std::uint32_t> neighbor_edges,
                             ArrayView<float> edge_weights)
    : offsets_(neighbors.offsets.begin(), neighbors.offsets.end())
{
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t e = 0; e < edge_weights.size(); ++e) {
    const float weight = edge_weights[e];
    if (!(weight >= 0.0f)) {
      throw std::invalid_argument("edge " + std::to_string(e) + " has the length " +
                                  std::to_string(weight) + "; lengths have to be 0 or more");
    }
    if (weight < INFINITE) {
      longest_ = std::max(longest_, weight);
      sum += weight;
      ++count;
    }
  }
  if (sum > 0.0) {
    bucket_width_ = sum / static_cast<double>(count);
  }
  arcs_.resize(neighbors.values.size());
  for (std::size_t i = 0; i < arcs_.size(); ++i) {
    arcs_[i] = {neighbors.values[i], edge_weights[neighbor_edges[i]]};
  }
}

void DijkstraGraph::check(const DijkstraQuery& query) const
{
  require(query.sources.size() == query.source_distances.size(),
          "there have to be as many source distances as sources");
  require(query.vertex_costs.empty() || query.vertex_costs.size() == vertexCount(),
          "there are " + std::to_string(query.vertex_costs.size()) + " vertex costs for " +
              std::to_string(vertexCount()) + " vertices");
  require(!std::isnan(query.cost_limit), "the cost limit is not a number");
  require(query.offset >= 0.0f, "the offset has to be 0 or more");
  for (std::size_t i = 0; i < query.sources.size(); ++i) {
    require(query.sources[i] < vertexCount(),
            "source vertex " + std::to_string(query.sources[i]) + " does not exist");
    require(query.source_distances[i] >= 0.0f && query.source_distances[i] < INFINITE,
            "the distance of source " + std::to_string(i) + " has to be finite and 0 or more");
  }
  for (const std::uint32_t target : query.targets) {
    require(target < vertexCount(), "target vertex " + std::to_string(target) + " does not exist");
  }
}

DijkstraField DijkstraGraph::solve(const DijkstraQuery& query, DijkstraQueue queue) const
{
  check(query);
  const ArrayView<float>& starts = query.source_distances;
  const double spread = starts.empty() ? 0.0
                                       : double{*std::max_element(starts.begin(), starts.end())} -
                                             *std::min_element(starts.begin(), starts.end());
  const double span = std::max<double>(longest_, spread);
  if (queue != DijkstraQueue::HEAP && BucketQueue::fits(bucket_width_, span)) {
    BucketQueue buckets(bucket_width_, span);
    Run run(*this, query);
    if (run.search(buckets)) {
      return run.takeField();
    }
  }
  require(queue != DijkstraQueue::BUCKETS, "the edge lengths differ too much for buckets");
  HeapQueue heap;
  Run run(*this, query);
  run.search(heap);
  return run.takeField();
}

}  // namespace mesh_map
