#include "distance/dijkstra/dijkstra.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <mesh_map/base/run_options.h>

#include "base/bucket_queue.h"
#include "base/require.h"
#include "distance/dijkstra/dijkstra_labels.h"

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

namespace {

/// One search: grows the labels from what is in a queue, until all up to the limit are final
/// (E. W. Dijkstra: A Note on Two Problems in Connexion with Graphs, 1959).
class DijkstraSearch
{
 public:
  using Entry = QueueEntry<float>;

  DijkstraSearch(const DijkstraGraph& graph, const VertexCosts& costs, DijkstraLabels& labels,
                 DijkstraStop& stop, const std::atomic<bool>* cancel)
      : graph_(graph), costs_(costs), labels_(labels), stop_(stop), cancel_(cancel)
  {
  }

  /// False where it was canceled. What is left is in the queue and in beyond() then. Even where it
  /// is canceled from the start it gets somewhat farther, so that steps that are all broken off
  /// come to an end.
  bool run()
  {
    while (queue_.open()) {
      stop_.settle(labels_, [this](float distance) { return queue_.isPassed(distance); });
      if (queue_.isPassed(stop_.limit)) {
        return !isSet(cancel_);
      }
      for (Entry entry; queue_.pop(entry);) {
        prefetch();
        if (entry.label == labels_[entry.vertex].distance) {
          expand(entry);
        }
        if (++steps_ % STEPS_PER_CANCEL_CHECK == 0 && isSet(cancel_)) {
          return false;
        }
      }
    }
    stop_.settle(labels_, [](float) { return true; });
    return !isSet(cancel_);
  }

  /// Entries beyond the limit that were popped.
  const std::vector<Entry>& beyond() const { return beyond_; }

  /// How many vertices' edges were gone over.
  std::size_t goneOver() const { return gone_over_; }

 private:
  static constexpr std::uint32_t STEPS_PER_CANCEL_CHECK = 1024;

  void expand(const Entry& entry)
  {
    if (entry.label > stop_.limit) {
      beyond_.push_back(entry);
      return;
    }
    ++gone_over_;
    for (const DijkstraGraph::Arc& arc : graph_.arcs(entry.vertex)) {
      const float distance = entry.label + arc.weight;
      DijkstraLabel& label = labels_[arc.to];
      if (distance < label.distance) {
        if (label.distance == std::numeric_limits<float>::infinity()) {
          if (!costs_.isPassable(arc.to)) {
            continue;
          }
          if (label.from == NO_INDEX) {
            labels_.touch(arc.to);
          }
        }
        label = {distance, entry.vertex};
        queue_.push(distance, arc.to);
      }
    }
  }

  /// Asks for the memory of entries that come soon: most of the time would go into waiting for it.
  [[gnu::always_inline]] void prefetch() const
  {
    constexpr std::size_t soon = 6, later = 16;
    if (const Entry* entry = queue_.peek(later)) {
      __builtin_prefetch(graph_.offset(entry->vertex));
      __builtin_prefetch(&labels_[entry->vertex]);
    }
    const Entry* entry = queue_.peek(soon);
    if (entry != nullptr && entry->label == labels_[entry->vertex].distance) {
      __builtin_prefetch(graph_.arcs(entry->vertex).begin());
      __builtin_prefetch(graph_.arcs(entry->vertex).end());
    }
  }

  const DijkstraGraph& graph_;
  const VertexCosts costs_;
  DijkstraLabels& labels_;
  BucketQueue<float>& queue_ = labels_.queue;
  DijkstraStop& stop_;
  const std::atomic<bool>* cancel_;
  std::vector<Entry> beyond_;
  std::size_t gone_over_ = 0;
  std::uint32_t steps_ = 0;
};

constexpr float INFINITE = std::numeric_limits<float>::infinity();

/// Where more than this part of all labels has to be taken back, computing all is no slower.
constexpr std::size_t TOO_MANY = 4;

}  // namespace

void VertexCosts::check(std::size_t vertex_count) const
{
  require(values.empty() || values.size() == vertex_count,
          "there are " + std::to_string(values.size()) + " vertex costs for " +
              std::to_string(vertex_count) + " vertices");
  require(!std::isnan(limit), "the cost limit is not a number");
}

std::shared_ptr<DijkstraPool> makeDijkstraPool(std::size_t vertex_count)
{
  return std::make_shared<DijkstraPool>(vertex_count);
}

DijkstraField::DijkstraField(std::shared_ptr<const DijkstraGraph> graph,
                             std::shared_ptr<DijkstraPool> pool, ArrayView<std::uint32_t> sources,
                             ArrayView<float> source_distances, const VertexCosts& costs)
    : graph_(std::move(graph)), pool_(std::move(pool)), costs_(costs)
{
  require(pool_->vertexCount() == vertexCount(), "the pool is for meshes of another size");
  require(sources.size() == source_distances.size(),
          "there have to be as many source distances as sources");
  costs.check(vertexCount());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    require(sources[i] < vertexCount(),
            "source vertex " + std::to_string(sources[i]) + " does not exist");
    require(source_distances[i] >= 0.0f && source_distances[i] < INFINITE,
            "the distance of source " + std::to_string(i) + " has to be finite and 0 or more");
    sources_.push_back({sources[i], source_distances[i]});
  }
  labels_ = pool_->take();
  start();
}

DijkstraField::~DijkstraField()
{
  pool_->give(std::move(labels_));
}

void DijkstraField::start()
{
  frontier_.clear();
  for (const Source& source : sources_) {
    offer(source.vertex, source.distance, source.vertex);
  }
}

/// Labels a vertex and puts it into the front, if that makes it nearer and it may be passed.
bool DijkstraField::offer(std::uint32_t vertex, float distance, std::uint32_t from)
{
  DijkstraLabel& label = (*labels_)[vertex];
  if (!(distance < label.distance) || !costs_.isPassable(vertex)) {
    return false;
  }
  if (label.from == NO_INDEX) {
    labels_->touch(vertex);
  }
  label = {distance, from};
  frontier_.push_back(vertex);
  return true;
}

bool DijkstraField::extend(const DijkstraReach& reach, const std::atomic<bool>* cancel)
{
  require(reach.offset >= 0.0f, "the offset has to be 0 or more");
  require(reach.max_distance >= 0.0f, "the maximum distance has to be 0 or more");
  for (const std::uint32_t target : reach.targets) {
    require(target < vertexCount(), "target vertex " + std::to_string(target) + " does not exist");
  }
  DijkstraStop stop{reach.max_distance, {reach.targets.begin(), reach.targets.end()}, reach.offset};
  stop.settle(*labels_, [this](float distance) { return distance <= limit_; });
  if (stop.limit <= limit_) {
    return true;
  }
  return run(stop, cancel);
}

/// Goes on from the front until all up to the stop is final.
bool DijkstraField::run(DijkstraStop& stop, const std::atomic<bool>* cancel)
{
  BucketQueue<float>& queue = labels_->queue;
  queue.reset(graph_->typical());
  for (const std::uint32_t v : frontier_) {
    queue.push((*labels_)[v].distance, v);
  }
  DijkstraSearch search(*graph_, costs_, *labels_, stop, cancel);
  const bool done = search.run();
  gone_over_ = search.goneOver();

  // What was queued becomes the front again, without what has become nearer since.
  frontier_.clear();
  const auto keep = [this](const QueueEntry<float>& entry) {
    if (entry.label == (*labels_)[entry.vertex].distance) {
      frontier_.push_back(entry.vertex);
    }
  };
  queue.forEach(keep);
  std::for_each(search.beyond().begin(), search.beyond().end(), keep);
  limit_ = stop.limit;
  if (!done) {
    limit_ = INFINITE;
    for (const std::uint32_t v : frontier_) {
      // as far as it is itself, there may be more beyond edges of no length
      limit_ = std::min(limit_, std::nextafter((*labels_)[v].distance, -INFINITE));
    }
  } else if (limit_ < INFINITE && frontier_.empty() && !isAnythingBeyond(limit_)) {
    limit_ = INFINITE;
  }
  return done;
}

bool DijkstraField::isAnythingBeyond(float limit) const
{
  bool found = false;
  labels_->forEachTouched([&](std::uint32_t v) {
    const float distance = (*labels_)[v].distance;
    found = found || (distance > limit && distance < INFINITE);
  });
  return found;
}

bool DijkstraField::reaches(std::uint32_t vertex) const
{
  const float distance = (*labels_)[vertex].distance;
  return distance <= limit_ && distance < INFINITE;
}

std::vector<float> DijkstraField::potential() const
{
  std::vector<float> potential(vertexCount(), INFINITE);
  labels_->forEachTouched([&](std::uint32_t v) {
    const float distance = (*labels_)[v].distance;
    potential[v] = distance <= limit_ ? distance : INFINITE;
  });
  return potential;
}

std::vector<std::uint32_t> DijkstraField::predecessors() const
{
  std::vector<std::uint32_t> predecessors(vertexCount());
  std::iota(predecessors.begin(), predecessors.end(), 0u);
  labels_->forEachTouched([&](std::uint32_t v) {
    if (reaches(v)) {
      predecessors[v] = (*labels_)[v].from;
    }
  });
  return predecessors;
}

std::vector<std::uint32_t> DijkstraField::pathFrom(std::uint32_t vertex) const
{
  require(vertex < vertexCount(), "vertex " + std::to_string(vertex) + " does not exist");
  std::vector<std::uint32_t> way;
  if (reaches(vertex)) {
    way.push_back(vertex);
    while ((*labels_)[way.back()].from != way.back()) {
      way.push_back((*labels_)[way.back()].from);
    }
  }
  return way;
}

// How a field follows changes: what depends on them is taken back, gets labels from what is left,
// and the search goes on from there.
bool DijkstraField::update(std::shared_ptr<const DijkstraGraph> graph, const VertexCosts& costs,
                           ArrayView<std::uint32_t> changed, std::size_t& count,
                           const std::atomic<bool>* cancel)
{
  costs.check(vertexCount());
  require(graph->vertexCount() == vertexCount(),
          "the graph has " + std::to_string(graph->vertexCount()) + " vertices, but the field " +
              std::to_string(vertexCount()));
  for (const std::uint32_t v : changed) {
    require(v < vertexCount(), "changed vertex " + std::to_string(v) + " does not exist");
  }
  graph_ = std::move(graph);
  costs_ = costs;
  std::vector<std::uint32_t> taken;
  if (takeBack(changed, taken)) {
    for (const Source& source : sources_) {
      offer(source.vertex, source.distance, source.vertex);
    }
    for (const std::uint32_t v : taken) {
      labelFromNeighbors(v);
    }
    for (const std::uint32_t v : changed) {
      labelFromNeighbors(v);
      offerToNeighbors(v);
    }
  } else {
    labels_->forget();
    start();
  }
  // each once: what lies beyond the limit stays there, and would be there more often each time
  std::sort(frontier_.begin(), frontier_.end());
  const auto isGone = [this](std::uint32_t v) { return !((*labels_)[v].distance < INFINITE); };
  frontier_.erase(
      std::remove_if(frontier_.begin(), std::unique(frontier_.begin(), frontier_.end()), isGone),
      frontier_.end());
  count += taken.size();
  if (limit_ < 0.0f) {
    return true;  // nothing was asked for so far
  }
  DijkstraStop stop{limit_, {}};
  const bool done = run(stop, cancel);
  count += gone_over_;
  return done;
}

/// Takes back each label that came through a vertex that is closed now, or over an edge that has
/// become longer. False where these are so many that nothing is worth keeping.
bool DijkstraField::takeBack(ArrayView<std::uint32_t> changed, std::vector<std::uint32_t>& taken)
{
  for (const std::uint32_t v : changed) {
    const float distance = (*labels_)[v].distance;
    if (!(distance < INFINITE)) {
      continue;  // and nothing came through it
    }
    if (!costs_.isPassable(v)) {
      take(v, taken);  // and below, what came through it
      continue;
    }
    const std::uint32_t from = (*labels_)[v].from;
    for (const DijkstraGraph::Arc& arc : graph_->arcs(v)) {
      const DijkstraLabel& neighbor = (*labels_)[arc.to];
      if (arc.to == from && neighbor.distance + arc.weight > distance) {
        take(v, taken);
        break;
      }
      if (neighbor.from == v && neighbor.distance < distance + arc.weight) {
        take(arc.to, taken);
      }
    }
  }
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (taken.size() > labels_->touchedCount() / TOO_MANY + 1) {
      return false;
    }
    const std::uint32_t v = taken[i];
    for (const DijkstraGraph::Arc& arc : graph_->arcs(v)) {
      const DijkstraLabel& neighbor = (*labels_)[arc.to];
      if (neighbor.from == v && neighbor.distance < INFINITE) {
        take(arc.to, taken);
      }
    }
  }
  return true;
}

void DijkstraField::take(std::uint32_t vertex, std::vector<std::uint32_t>& taken)
{
  (*labels_)[vertex] = {INFINITE, vertex};
  taken.push_back(vertex);
}

/// Gives a vertex the least distance that its neighbors offer, if that makes it nearer.
void DijkstraField::labelFromNeighbors(std::uint32_t vertex)
{
  float least = INFINITE;
  std::uint32_t from = vertex;
  for (const DijkstraGraph::Arc& arc : graph_->arcs(vertex)) {
    const float distance = (*labels_)[arc.to].distance + arc.weight;
    if (distance < least) {
      least = distance;
      from = arc.to;
    }
  }
  offer(vertex, least, from);
}

void DijkstraField::offerToNeighbors(std::uint32_t vertex)
{
  const float distance = (*labels_)[vertex].distance;
  if (distance < INFINITE) {
    for (const DijkstraGraph::Arc& arc : graph_->arcs(vertex)) {
      offer(arc.to, distance + arc.weight, vertex);
    }
  }
}

}  // namespace mesh_map
