#include <mesh_map/dijkstra.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "dijkstra_labels.h"
#include "dijkstra_search.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

void require(bool condition, const std::string& message)
{
  if (!condition) {
    throw std::invalid_argument(message);
  }
}

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
  front_.clear();
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
  front_.push_back(vertex);
  return true;
}

bool DijkstraField::extend(const DijkstraReach& reach, const std::atomic<bool>* cancel,
                           DijkstraQueue queue)
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
  return run(stop, cancel, queue);
}

/// Goes on from the front until all up to the stop is final.
bool DijkstraField::run(DijkstraStop& stop, const std::atomic<bool>* cancel, DijkstraQueue kind)
{
  float lowest = INFINITE, highest = 0.0f;
  for (const std::uint32_t v : front_) {
    lowest = std::min(lowest, (*labels_)[v].distance);
    highest = std::max(highest, (*labels_)[v].distance);
  }
  const double spread = front_.empty() ? 0.0 : double{highest} - lowest;
  const double span = std::max<double>(graph_->longest(), spread);
  const bool fits = BucketQueue::fits(graph_->typical(), span);
  require(fits || kind != DijkstraQueue::BUCKETS, "the edge lengths differ too much for buckets");

  DijkstraSearch search(*graph_, costs_, *labels_, stop, cancel);
  std::vector<QueueEntry> entries;
  for (const std::uint32_t v : front_) {
    entries.push_back({(*labels_)[v].distance, v});
  }
  SearchEnd end = SearchEnd::OVERFLOWED;
  if (fits && kind != DijkstraQueue::HEAP) {
    BucketQueue& buckets = labels_->buckets;
    buckets.start(graph_->typical(), span, lowest);
    buckets.pushAll(entries);
    end = search.run(buckets);
    buckets.takeAll(entries);
  }
  if (end == SearchEnd::OVERFLOWED) {
    HeapQueue heap;
    heap.pushAll(entries);
    end = search.run(heap);
    heap.takeAll(entries);
  }
  entries.insert(entries.end(), search.beyond().begin(), search.beyond().end());
  gone_over_ = search.goneOver();
  keepFront(entries);
  if (end == SearchEnd::CANCELLED) {
    limit_ = INFINITE;
    for (const std::uint32_t v : front_) {
      // as far as it is itself, there may be more beyond edges of no length
      limit_ = std::min(limit_, std::nextafter((*labels_)[v].distance, -INFINITE));
    }
    return false;
  }
  limit_ = stop.limit;
  if (limit_ < INFINITE && front_.empty() && !isAnythingBeyond(limit_)) {
    limit_ = INFINITE;
  }
  return true;
}

/// What was queued becomes the front again, without what has become nearer since.
void DijkstraField::keepFront(std::vector<QueueEntry>& entries)
{
  front_.clear();
  for (const QueueEntry& entry : entries) {
    if (entry.distance == (*labels_)[entry.vertex].distance) {
      front_.push_back(entry.vertex);
    }
  }
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

void DijkstraField::writePotential(float* potential) const
{
  std::fill(potential, potential + vertexCount(), INFINITE);
  labels_->forEachTouched([&](std::uint32_t v) {
    const float distance = (*labels_)[v].distance;
    potential[v] = distance <= limit_ ? distance : INFINITE;
  });
}

void DijkstraField::writePredecessors(std::uint32_t* predecessors) const
{
  for (std::uint32_t v = 0; v < vertexCount(); ++v) {
    predecessors[v] = v;
  }
  labels_->forEachTouched([&](std::uint32_t v) {
    if (reaches(v)) {
      predecessors[v] = (*labels_)[v].from;
    }
  });
}

std::vector<std::uint32_t> DijkstraField::wayFrom(std::uint32_t vertex) const
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

}  // namespace mesh_map
