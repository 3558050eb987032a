#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace mesh_map {

/// Vertices and weighted edges between them. Immutable, so any number of threads may use it.
class DijkstraGraph
{
 public:
  struct Arc
  {
    std::uint32_t to;
    float weight;
  };

  /// Row v of `neighbors` holds the vertices next to v, and `neighbor_edges` beside it the edges in
  /// between; +inf as the weight of an edge closes it. Throws std::invalid_argument for a weight
  /// that is NaN or negative.
  DijkstraGraph(const RowsView& neighbors, ArrayView<std::uint32_t> neighbor_edges,
                ArrayView<float> edge_weights);

  /// The same with other weights, at the price of a copy and of the edges whose weights differ.
  /// `before` are the weights of this graph, `edges` the two vertices of each edge. Throws
  /// std::invalid_argument as above.
  std::shared_ptr<DijkstraGraph> withWeights(ArrayView<std::uint32_t> edges,
                                             ArrayView<float> before, ArrayView<float> after) const;

  std::size_t vertexCount() const { return offsets_->size() - 1; }

  ArrayView<Arc> arcs(std::uint32_t vertex) const
  {
    const std::uint32_t begin = (*offsets_)[vertex];
    return {arcs_.data() + begin, (*offsets_)[vertex + 1] - begin};
  }

  /// Where arcs() looks: for prefetching.
  const std::uint32_t* offset(std::uint32_t vertex) const { return offsets_->data() + vertex; }

  /// About the mean of the finite weights; above 0.
  double typical() const { return typical_; }

 private:
  DijkstraGraph(const DijkstraGraph&) = default;

  void setWeight(std::uint32_t from, std::uint32_t to, float weight);
  void measure(ArrayView<float> edge_weights);

  std::shared_ptr<const LargeArray<std::uint32_t>> offsets_;
  LargeArray<Arc> arcs_;
  double typical_ = 1.0;
  std::size_t changed_ = 0;  // edges, since the weights were measured
};

/// The vertices at edges whose weights differ; one may be there several times.
std::vector<std::uint32_t> verticesAtChanges(ArrayView<std::uint32_t> edges,
                                             ArrayView<float> before, ArrayView<float> after);

/// Is each weight either the length of its edge or infinite?
bool areLengthsOrClosed(ArrayView<float> weights, ArrayView<float> lengths);

}  // namespace mesh_map
