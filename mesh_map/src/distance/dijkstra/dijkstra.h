#pragma once

#include <mesh_map/base/array_view.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "distance/dijkstra/dijkstra_graph.h"

namespace mesh_map {

class DijkstraLabels;
class DijkstraPool;
struct DijkstraStop;

/// Cost per vertex, or none. Vertices with +inf (lethal), NaN (unknown) or more than the limit are
/// never passed, neither as source nor as target.
struct VertexCosts
{
  ArrayView<float> values;
  float limit = std::numeric_limits<float>::infinity();

  /// NaN fails the first comparison, +inf the second.
  bool isPassable(std::uint32_t vertex) const
  {
    return values.empty() ||
           (values[vertex] <= limit && values[vertex] < std::numeric_limits<float>::infinity());
  }

  /// Throws std::invalid_argument where this is not for so many vertices, or the limit is NaN.
  void check(std::size_t vertex_count) const;
};

/// How far a field shall be known.
struct DijkstraReach
{
  /// Where given, `offset` beyond the distance at which all of them are reached. If one cannot be
  /// reached, everywhere.
  ArrayView<std::uint32_t> targets;
  float offset = 0.0f;

  float max_distance = std::numeric_limits<float>::infinity();
};

/// Memory for fields on meshes of one size; makes the next field cheap. For any number of threads.
std::shared_ptr<DijkstraPool> makeDijkstraPool(std::size_t vertex_count);

/// Shortest ways over weighted edges from sources to everywhere, as far as asked for: it goes on
/// where it stopped, and follows changes.
///
/// Distances are sums in 32-bit floats along the way from the source, as in a plain Dijkstra with a
/// heap: the same bits, in whatever steps the field was made, since such sums grow monotonically
/// with each of their terms.
///
/// At any time, each edge whose one end is labeled and does not wait in the front either ends at a
/// vertex that may not be passed, or could not make its other end nearer. So everything nearer than
/// the nearest vertex of the front is final, wherever a search was broken off.
///
/// One writer at a time, and no reader meanwhile.
class DijkstraField
{
 public:
  /// Nothing is known yet. `source_distances` are finite and >= 0, one per source, the costs have
  /// to outlive the field or the next update(). Throws std::invalid_argument for other arguments.
  DijkstraField(std::shared_ptr<const DijkstraGraph> graph, std::shared_ptr<DijkstraPool> pool,
                ArrayView<std::uint32_t> sources, ArrayView<float> source_distances,
                const VertexCosts& costs);
  ~DijkstraField();
  DijkstraField(const DijkstraField&) = delete;
  DijkstraField& operator=(const DijkstraField&) = delete;

  /// Goes on until the field is known so far. False where it was canceled: then limit() tells how
  /// far it is. Throws std::invalid_argument for an argument out of its range.
  bool extend(const DijkstraReach& reach, const std::atomic<bool>* cancel = nullptr);

  /// Makes it the field of another graph (of the same vertices and edges) and other costs, up to
  /// the same limit; these may differ only at the vertices `changed` and at edges that end there.
  /// False where it was canceled, as above. Adds to `count` how many labels were taken back or
  /// gone over again; where that is 0, nothing has changed.
  bool update(std::shared_ptr<const DijkstraGraph> graph, const VertexCosts& costs,
              ArrayView<std::uint32_t> changed, std::size_t& count,
              const std::atomic<bool>* cancel = nullptr);

  std::size_t vertexCount() const { return graph_->vertexCount(); }
  const VertexCosts& costs() const { return costs_; }

  /// All distances up to this one are final: +inf where nothing is beyond, -inf where none is.
  float limit() const { return limit_; }

  /// Is its final distance known, and finite?
  bool reaches(std::uint32_t vertex) const;

  /// The distance to the nearest source for each vertex, +inf where it is not reached.
  std::vector<float> potential() const;

  /// The next vertex on the way there; the vertex itself at a source and where it is not reached.
  std::vector<std::uint32_t> predecessors() const;

  /// The vertices from this one to its source; none where it is not reached.
  std::vector<std::uint32_t> pathFrom(std::uint32_t vertex) const;

 private:
  struct Source
  {
    std::uint32_t vertex;
    float distance;
  };

  void start();
  bool run(DijkstraStop& stop, const std::atomic<bool>* cancel);
  bool isAnythingBeyond(float limit) const;

  // of update()
  bool takeBack(ArrayView<std::uint32_t> changed, std::vector<std::uint32_t>& taken);
  void take(std::uint32_t vertex, std::vector<std::uint32_t>& taken);
  void labelFromNeighbors(std::uint32_t vertex);
  void offerToNeighbors(std::uint32_t vertex);
  bool offer(std::uint32_t vertex, float distance, std::uint32_t from);

  std::shared_ptr<const DijkstraGraph> graph_;
  std::shared_ptr<DijkstraPool> pool_;
  std::unique_ptr<DijkstraLabels> labels_;
  VertexCosts costs_;
  std::vector<Source> sources_;
  std::vector<std::uint32_t> frontier_;  // labeled, but its edges have not been gone over since
  float limit_ = -std::numeric_limits<float>::infinity();
  std::size_t gone_over_ = 0;  // by the last run
};

}  // namespace mesh_map
