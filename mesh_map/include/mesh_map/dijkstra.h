#ifndef MESH_MAP_DIJKSTRA_H
#define MESH_MAP_DIJKSTRA_H

#include <mesh_map/array_view.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace mesh_map {

/// What DijkstraGraph::solve is asked. Views have to outlive the call.
struct DijkstraQuery
{
  ArrayView<std::uint32_t> sources;
  ArrayView<float> source_distances;  ///< one per source, finite and >= 0

  /// Cost per vertex, or empty. Vertices with +inf (lethal), NaN (unknown) or more than the limit
  /// are never passed, neither as source nor as target.
  ArrayView<float> vertex_costs;
  float cost_limit = std::numeric_limits<float>::infinity();

  /// Where given, the field ends `offset` beyond the distance at which all of them are reached.
  ArrayView<std::uint32_t> targets;
  float offset = 0.0f;

  const std::atomic<bool>* cancel = nullptr;
};

/// Which priority queue carries the front. The results do not depend on it.
enum class DijkstraQueue
{
  AUTOMATIC,  ///< buckets, or the heap where the edge lengths are too different for buckets
  BUCKETS,    ///< throws std::invalid_argument where buckets cannot do it
  HEAP
};

struct DijkstraField
{
  std::vector<float> potential;  ///< distance to the nearest source, +inf where not reached
  std::vector<std::uint32_t>
      predecessors;        ///< next vertex on the way there; the vertex itself where there is none
  bool cancelled = false;  ///< then the field is incomplete and of no use
};

/// Shortest ways over weighted edges from sources to everywhere. Immutable, so several threads may
/// solve at once.
///
/// Distances are sums in 32-bit floats along the way from the source, as in a plain Dijkstra with a
/// heap: the same bits, whatever queue is used, since such sums grow monotonically with each of
/// their terms.
class DijkstraGraph
{
 public:
  /// Throws std::invalid_argument for an edge weight that is NaN or negative; +inf closes an edge.
  DijkstraGraph(const RowsView& neighbors, ArrayView<std::uint32_t> neighbor_edges,
                ArrayView<float> edge_weights);

  /// Throws std::invalid_argument for a query outside of the ranges above.
  DijkstraField solve(const DijkstraQuery& query,
                      DijkstraQueue queue = DijkstraQueue::AUTOMATIC) const;

  std::size_t vertexCount() const { return offsets_.size() - 1; }

 private:
  struct Arc
  {
    std::uint32_t to;
    float weight;
  };
  class Run;

  void check(const DijkstraQuery& query) const;

  std::vector<std::uint32_t> offsets_;
  std::vector<Arc> arcs_;
  float longest_ = 0.0f;       // of the finite weights
  double bucket_width_ = 1.0;  // their mean
};

}  // namespace mesh_map

#endif  // MESH_MAP_DIJKSTRA_H
