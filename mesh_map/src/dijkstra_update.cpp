// How a field follows changes: what depends on them is taken back, gets labels from what is left,
// and the search goes on from there.
#include <mesh_map/dijkstra.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "dijkstra_labels.h"
#include "dijkstra_search.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

/// Where more than this part of all labels has to be taken back, computing all is no slower.
constexpr std::size_t TOO_MANY = 4;

}  // namespace

bool DijkstraField::update(std::shared_ptr<const DijkstraGraph> graph, const VertexCosts& costs,
                           ArrayView<std::uint32_t> changed, std::size_t& count,
                           const std::atomic<bool>* cancel)
{
  costs.check(vertexCount());
  if (graph->vertexCount() != vertexCount()) {
    throw std::invalid_argument("the graph has " + std::to_string(graph->vertexCount()) +
                                " vertices, but the field " + std::to_string(vertexCount()));
  }
  for (const std::uint32_t v : changed) {
    if (v >= vertexCount()) {
      throw std::invalid_argument("changed vertex " + std::to_string(v) + " does not exist");
    }
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
  std::sort(front_.begin(), front_.end());
  const auto isGone = [this](std::uint32_t v) { return !((*labels_)[v].distance < INFINITE); };
  front_.erase(std::remove_if(front_.begin(), std::unique(front_.begin(), front_.end()), isGone),
               front_.end());
  count += taken.size();
  if (limit_ < 0.0f) {
    return true;  // nothing was asked for so far
  }
  DijkstraStop stop{limit_, {}};
  const bool done = run(stop, cancel, DijkstraQueue::AUTOMATIC);
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
    bool is_kept = costs_.isPassable(v);
    const std::uint32_t from = (*labels_)[v].from;
    for (const DijkstraGraph::Arc* arc = graph_->begin(v); is_kept && arc != graph_->end(v);
         ++arc) {
      const DijkstraLabel& neighbor = (*labels_)[arc->to];
      if (arc->to == from && neighbor.distance + arc->weight > distance) {
        is_kept = false;
      } else if (neighbor.from == v && neighbor.distance < distance + arc->weight) {
        take(arc->to, taken);
      }
    }
    if (!is_kept) {
      take(v, taken);  // and below, what came through it
    }
  }
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (taken.size() > labels_->touchedCount() / TOO_MANY + 1) {
      return false;
    }
    const std::uint32_t v = taken[i];
    for (const DijkstraGraph::Arc* arc = graph_->begin(v); arc != graph_->end(v); ++arc) {
      const DijkstraLabel& neighbor = (*labels_)[arc->to];
      if (neighbor.from == v && neighbor.distance < INFINITE) {
        take(arc->to, taken);
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
  for (const DijkstraGraph::Arc* arc = graph_->begin(vertex); arc != graph_->end(vertex); ++arc) {
    const float distance = (*labels_)[arc->to].distance + arc->weight;
    if (distance < least) {
      least = distance;
      from = arc->to;
    }
  }
  offer(vertex, least, from);
}

void DijkstraField::offerToNeighbors(std::uint32_t vertex)
{
  const float distance = (*labels_)[vertex].distance;
  for (const DijkstraGraph::Arc* arc = graph_->begin(vertex);
       distance < INFINITE && arc != graph_->end(vertex); ++arc) {
    offer(arc->to, distance + arc->weight, vertex);
  }
}

}  // namespace mesh_map
