#include "distance/dijkstra/dijkstra_graph.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

/// Where more than this part of all weights has changed, they are measured again.
constexpr std::size_t MANY = 8;

void checkWeight(std::size_t edge, float weight)
{
  if (!(weight >= 0.0f)) {
    throw std::invalid_argument("edge " + std::to_string(edge) + " has the length " +
                                std::to_string(weight) + "; lengths have to be 0 or more");
  }
}

/// Calls body(edge) for each that differs; blocks without a difference take one pass of the memory.
template <class Body>
void forEachChange(ArrayView<float> before, ArrayView<float> after, const Body& body)
{
  constexpr std::size_t block = 1024;
  for (std::size_t start = 0; start < after.size(); start += block) {
    const std::size_t end = std::min(start + block, after.size());
    unsigned different = 0;
    for (std::size_t e = start; e < end; ++e) {
      different |= static_cast<unsigned>(!(before[e] == after[e]));
    }
    for (std::size_t e = start; different != 0 && e < end; ++e) {
      if (!(before[e] == after[e])) {
        body(e);
      }
    }
  }
}

}  // namespace

DijkstraGraph::DijkstraGraph(const RowsView& neighbors, ArrayView<std::uint32_t> neighbor_edges,
                             ArrayView<float> edge_weights)
    : offsets_(std::make_shared<LargeArray<std::uint32_t>>(neighbors.offsets.begin(),
                                                           neighbors.offsets.end())),
      arcs_(neighbors.values.size())
{
  for (std::size_t e = 0; e < edge_weights.size(); ++e) {
    checkWeight(e, edge_weights[e]);
  }
  measure(edge_weights);
  for (std::size_t i = 0; i < arcs_.size(); ++i) {
    arcs_[i] = {neighbors.values[i], edge_weights[neighbor_edges[i]]};
  }
}

void DijkstraGraph::measure(ArrayView<float> edge_weights)
{
  double sum = 0.0;
  std::size_t count = 0;
  for (const float weight : edge_weights) {
    if (weight < INFINITE) {
      sum += weight;
      ++count;
    }
  }
  typical_ = sum > 0.0 ? sum / static_cast<double>(count) : 1.0;
  changed_ = 0;
}

std::shared_ptr<DijkstraGraph> DijkstraGraph::withWeights(ArrayView<std::uint32_t> edges,
                                                          ArrayView<float> before,
                                                          ArrayView<float> after) const
{
  std::shared_ptr<DijkstraGraph> graph(new DijkstraGraph(*this));
  forEachChange(before, after, [&](std::size_t e) {
    checkWeight(e, after[e]);
    ++graph->changed_;
    graph->setWeight(edges[2 * e], edges[2 * e + 1], after[e]);
    graph->setWeight(edges[2 * e + 1], edges[2 * e], after[e]);
  });
  if (graph->changed_ > after.size() / MANY) {
    graph->measure(after);
  }
  return graph;
}

void DijkstraGraph::setWeight(std::uint32_t from, std::uint32_t to, float weight)
{
  Arc* const last = arcs_.data() + (*offsets_)[from + 1];
  for (Arc* arc = arcs_.data() + (*offsets_)[from]; arc != last; ++arc) {
    if (arc->to == to) {
      arc->weight = weight;
    }
  }
}

std::vector<std::uint32_t> verticesAtChanges(ArrayView<std::uint32_t> edges,
                                             ArrayView<float> before, ArrayView<float> after)
{
  std::vector<std::uint32_t> vertices;
  forEachChange(before, after, [&](std::size_t e) {
    vertices.push_back(edges[2 * e]);
    vertices.push_back(edges[2 * e + 1]);
  });
  return vertices;
}

bool areLengthsOrClosed(ArrayView<float> weights, ArrayView<float> lengths)
{
  bool found = false;
  forEachChange(lengths, weights, [&](std::size_t e) { found = found || weights[e] != INFINITE; });
  return !found;
}

}  // namespace mesh_map
