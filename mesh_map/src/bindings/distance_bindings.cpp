// Distances over edges and over the surface for Python (private; see mesh_map.dijkstra and
// mesh_map.wave_front).

#include <mesh_map/distance/fast_marching/fast_marching.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <memory>
#include <utility>
#include <vector>

#include "bindings/bindings.h"
#include "distance/dijkstra/dijkstra.h"
#include "distance/dijkstra/dijkstra_labels.h"
#include "distance/obstacles/inflation.h"

namespace mesh_map {

namespace {

std::shared_ptr<DijkstraGraph> makeGraph(Array offsets, Array neighbors, Array neighbor_edges,
                                         Array edge_weights)
{
  const auto weights = view<float>(edge_weights, "edge_lengths", {ANY});
  const auto vertex_count = static_cast<std::size_t>(offsets.size() - (offsets.size() > 0));
  const RowsView rows = rowsView(offsets, neighbors, vertex_count, "neighbors");
  const auto edges = view<std::uint32_t>(neighbor_edges, "neighbor_edges", {neighbors.size()});
  checkIndices(edges, weights.size(), "neighbor_edges");
  const WithoutGil release;
  return std::make_shared<DijkstraGraph>(rows, edges, weights);
}

/// Edges, and two weights for each.
struct EdgeWeights
{
  EdgeWeights(Array edge_array, Array before_array, Array after_array)
      : edges(view<std::uint32_t>(edge_array, "edges", {ANY, 2})),
        before(view<float>(before_array, "edge_lengths before", {edge_array.shape(0)})),
        after(view<float>(after_array, "edge_lengths", {edge_array.shape(0)}))
  {
  }

  ArrayView<std::uint32_t> edges;
  ArrayView<float> before, after;
};

std::shared_ptr<DijkstraGraph> graphWithWeights(const DijkstraGraph& self, Array edges,
                                                Array before, Array after)
{
  const EdgeWeights weights(edges, before, after);
  checkIndices(weights.edges, self.vertexCount(), "edges");
  const WithoutGil release;
  return self.withWeights(weights.edges, weights.before, weights.after);
}

py::array changedVertices(Array edges, Array before, Array after)
{
  const EdgeWeights weights(edges, before, after);
  return toArray(
      unlocked([&] { return verticesAtChanges(weights.edges, weights.before, weights.after); }));
}

bool lengthsOrClosed(Array weights, Array lengths)
{
  const auto values = view<float>(weights, "edge weights", {ANY});
  const auto expected = view<float>(lengths, "edge lengths", {weights.size()});
  return unlocked([&] { return areLengthsOrClosed(values, expected); });
}

/// A field, and the costs that it looks at.
class DijkstraKernel
{
 public:
  DijkstraKernel(std::shared_ptr<DijkstraGraph> graph, std::shared_ptr<DijkstraPool> pool,
                 Array sources, Array source_distances, const py::object& costs, float cost_limit)
      : kept_costs_(costs)
  {
    const VertexCosts vertex_costs = costsView(costs, cost_limit, graph->vertexCount());
    const auto vertices = view<std::uint32_t>(sources, "sources", {ANY});
    const auto distances = view<float>(source_distances, "source distances", {sources.size()});
    const WithoutGil release;
    field_ = std::make_unique<DijkstraField>(std::move(graph), std::move(pool), vertices, distances,
                                             vertex_costs);
  }

  bool extend(Array targets, float offset, float max_distance, const CancelFlag* cancel)
  {
    DijkstraReach reach;
    reach.targets = view<std::uint32_t>(targets, "targets", {ANY});
    reach.offset = offset;
    reach.max_distance = max_distance;
    return unlocked([&] { return field_->extend(reach, flagOf(cancel)); });
  }

  py::tuple update(std::shared_ptr<DijkstraGraph> graph, const py::object& costs, Array changed,
                   const CancelFlag* cancel)
  {
    const VertexCosts vertex_costs = costsView(costs, field_->costs().limit, field_->vertexCount());
    const auto vertices = view<std::uint32_t>(changed, "changed", {ANY});
    kept_costs_ = py::make_tuple(kept_costs_, costs);  // whichever it looks at after an exception
    std::size_t count = 0;
    const bool done = unlocked([&] {
      return field_->update(std::move(graph), vertex_costs, vertices, count, flagOf(cancel));
    });
    kept_costs_ = costs;
    return py::make_tuple(done, count);
  }

  /// The vertices that may be passed with one of the costs, and not with the other.
  py::array openedOrClosed(const py::object& costs) const
  {
    const VertexCosts& before = field_->costs();
    const VertexCosts after = costsView(costs, before.limit, field_->vertexCount());
    return toArray(unlocked([&] {
      std::vector<std::uint32_t> vertices;
      for (std::uint32_t v = 0; v < field_->vertexCount(); ++v) {
        if (before.isPassable(v) != after.isPassable(v)) {
          vertices.push_back(v);
        }
      }
      return vertices;
    }));
  }

  py::array potential() const
  {
    return toArray(unlocked([this] { return field_->potential(); }));
  }

  py::array predecessors() const
  {
    return toArray(unlocked([this] { return field_->predecessors(); }));
  }

  py::array pathFrom(std::uint32_t vertex) const { return toArray(field_->pathFrom(vertex)); }

  float limit() const { return field_->limit(); }

 private:
  static VertexCosts costsView(const py::object& costs, float limit, std::size_t vertex_count)
  {
    return {viewOrNone<float>(costs, "vertex_costs", {static_cast<py::ssize_t>(vertex_count)}),
            limit};
  }

  py::object kept_costs_;
  std::unique_ptr<DijkstraField> field_;
};

}  // namespace

void bindDijkstra(py::module_& module)
{
  py::class_<DijkstraGraph, std::shared_ptr<DijkstraGraph>>(module, "_DijkstraGraph",
                                                            py::module_local())
      .def(py::init(&makeGraph))
      .def("_with_weights", &graphWithWeights);
  py::class_<DijkstraPool, std::shared_ptr<DijkstraPool>>(module, "_DijkstraPool",
                                                          py::module_local())
      .def(py::init(&makeDijkstraPool));
  py::class_<DijkstraKernel>(module, "_DijkstraField", py::module_local())
      .def(py::init<std::shared_ptr<DijkstraGraph>, std::shared_ptr<DijkstraPool>, const py::array&,
                    const py::array&, const py::object&, float>())
      .def("_extend", &DijkstraKernel::extend)
      .def("_update", &DijkstraKernel::update)
      .def("_opened_or_closed", &DijkstraKernel::openedOrClosed)
      .def("_potential", &DijkstraKernel::potential)
      .def("_predecessors", &DijkstraKernel::predecessors)
      .def("_way_from", &DijkstraKernel::pathFrom)
      .def("_limit", &DijkstraKernel::limit);
  module.def("_vertices_at_changes", &changedVertices);
  module.def("_are_lengths_or_closed", &lengthsOrClosed);
}

namespace {

std::shared_ptr<FastMarchingMesh> makeMesh(Array vertices, Array faces, Array offsets,
                                           Array vertex_faces, unsigned threads)
{
  const MeshView mesh = meshView(vertices, faces);
  const RowsView rows = rowsView(offsets, vertex_faces, mesh.faceCount(), "vertex_faces");
  const WithoutGil release;
  return std::make_shared<FastMarchingMesh>(mesh, rows, threads);
}

ArrayView<std::uint8_t> lethalView(const ObstacleDistance& self, Array lethal)
{
  const auto count = static_cast<py::ssize_t>(self.mesh().vertexCount());
  return view<std::uint8_t>(lethal, "lethal", {count});
}

bool computeObstacles(ObstacleDistance& self, Array lethal, const CancelFlag* cancel)
{
  const ArrayView<std::uint8_t> flags = lethalView(self, lethal);
  return unlocked([&] { return self.compute(flags, flagOf(cancel)); });
}

py::array updateObstacles(ObstacleDistance& self, Array lethal)
{
  const ArrayView<std::uint8_t> flags = lethalView(self, lethal);
  return toArray(unlocked([&] { return self.update(flags); }));
}

py::array obstacleDistances(const ObstacleDistance& self)
{
  return toArray(std::vector<float>(self.distances().begin(), self.distances().end()));
}

py::array obstacleDistancesOf(const ObstacleDistance& self, Array vertices)
{
  const auto wanted = indexView(vertices, self.mesh().vertexCount(), "vertices");
  std::vector<float> distances;
  for (const std::uint32_t v : wanted) {
    distances.push_back(self.distances()[v]);
  }
  return toArray(std::move(distances));
}

py::array obstacleRepulsion(const ObstacleDistance& self, const Fading& fading)
{
  return toRows(unlocked([&] { return repulsion(self, fading); }), 3);
}

py::array obstacleRepulsionOf(const ObstacleDistance& self, Array vertices, const Fading& fading)
{
  const auto wanted = indexView(vertices, self.mesh().vertexCount(), "vertices");
  return toRows(unlocked([&] { return repulsion(self, wanted, fading); }), 3);
}

py::array obstacleNeighbors(const ObstacleDistance& self, Array vertices)
{
  return toArray(
      withNeighbors(self.mesh(), indexView(vertices, self.mesh().vertexCount(), "vertices")));
}

py::array computeFadingCosts(Array distances, const Fading& fading)
{
  const auto values = view<float>(distances, "distances", {ANY});
  return toArray(unlocked([&] { return fadingCosts(values, fading); }));
}

}  // namespace

void bindObstacleDistance(py::module_& module)
{
  py::class_<FastMarchingMesh, std::shared_ptr<FastMarchingMesh>>(module, "_FastMarchingMesh",
                                                                  py::module_local())
      .def(py::init(&makeMesh));
  py::class_<Fading>(module, "_Fading", py::module_local())
      .def(py::init([](double inscribed_radius, double inflation_radius, double lethal_value,
                       double inscribed_value, bool is_exponential, double cost_scaling) {
        return Fading{inscribed_radius, inflation_radius, lethal_value,
                      inscribed_value,  is_exponential,   cost_scaling};
      }));
  py::class_<ObstacleDistance>(module, "_ObstacleDistance", py::module_local())
      .def(py::init([](std::shared_ptr<FastMarchingMesh> mesh, float max_distance) {
        const WithoutGil release;
        return std::make_unique<ObstacleDistance>(std::move(mesh), max_distance);
      }))
      .def("_compute", &computeObstacles)
      .def("_update", &updateObstacles)
      .def("_distances", &obstacleDistances)
      .def("_distances_of", &obstacleDistancesOf)
      .def("_repulsion", &obstacleRepulsion)
      .def("_repulsion_of", &obstacleRepulsionOf)
      .def("_with_neighbors", &obstacleNeighbors);
  module.def("_fading_costs", &computeFadingCosts);
}

namespace {

std::vector<FastMarchingSeed> seedsOf(Array vertices, Array labels)
{
  const auto vertex_view = view<std::uint32_t>(vertices, "sources", {ANY});
  const auto label_view = view<double>(labels, "source distances", {vertices.size()});
  std::vector<FastMarchingSeed> seeds;
  for (std::size_t i = 0; i < vertex_view.size(); ++i) {
    seeds.push_back({vertex_view[i], label_view[i]});
  }
  return seeds;
}

/// A field, and what its kernels are given again each time.
class Field
{
 public:
  Field(std::shared_ptr<FastMarchingPool> pool, Array sources, Array source_labels, Object slowness)
      : vertex_count_(static_cast<py::ssize_t>(pool->mesh().vertexCount())), slowness_(slowness)
  {
    const ArrayView<float> values = slownessView();
    std::vector<FastMarchingSeed> seeds = seedsOf(sources, source_labels);
    const WithoutGil release;
    field_ = std::make_unique<FastMarchingField>(std::move(pool), std::move(seeds), values);
  }

  Field(const Field&) = delete;
  Field& operator=(const Field&) = delete;

  /// Clears buffers for later, which takes milliseconds: other threads go on meanwhile.
  ~Field()
  {
    const WithoutGil release;
    field_.reset();
  }

  bool extend(Array targets, double offset, double max_distance, const CancelFlag* cancel)
  {
    FastMarchingStop stop;
    stop.targets = view<std::uint32_t>(targets, "targets", {ANY});
    stop.offset = offset;
    stop.max_distance = max_distance;
    stop.cancel = flagOf(cancel);
    const ArrayView<float> values = slownessView();
    return unlocked([&] { return field_->extend(values, stop); });
  }

  py::tuple update(Array sources, Array source_labels, Object slowness, Array changed,
                   const CancelFlag* cancel)
  {
    std::vector<FastMarchingSeed> seeds = seedsOf(sources, source_labels);
    const auto vertices = view<std::uint32_t>(changed, "changed", {ANY});
    const py::object before = slowness_;
    slowness_ = slowness;
    FastMarchingField::Update done;
    try {
      const ArrayView<float> values = slownessView();
      done = unlocked(
          [&] { return field_->update(std::move(seeds), values, vertices, flagOf(cancel)); });
    } catch (...) {
      slowness_ = before;
      throw;
    }
    return py::make_tuple(done.count, done.canceled);
  }

  double limit() const { return field_->limit(); }

  py::array potential() const
  {
    return toArray(unlocked([this] { return field_->potential(); }));
  }

  /// The labels themselves; the field lives as long as this array does.
  static py::array labels(Object self)
  {
    const ArrayView<double> labels = py::cast<const Field&>(self).field_->labels();
    return memoryOf(self, labels.data(), {labels.size()});
  }

 private:
  ArrayView<float> slownessView() const
  {
    return viewOrNone<float>(slowness_, "slowness", {vertex_count_});
  }

  py::ssize_t vertex_count_;
  py::object slowness_;
  std::unique_ptr<FastMarchingField> field_;
};

}  // namespace

void bindFastMarching(py::module_& module)
{
  py::class_<FastMarchingPool, std::shared_ptr<FastMarchingPool>>(module, "_FastMarchingPool",
                                                                  py::module_local())
      .def(py::init([](std::shared_ptr<FastMarchingMesh> mesh) {
        return std::make_shared<FastMarchingPool>(std::move(mesh));
      }));
  py::class_<Field>(module, "_FastMarchingField", py::module_local())
      .def(py::init<std::shared_ptr<FastMarchingPool>, Array, Array, Object>())
      .def("_extend", &Field::extend)
      .def("_update", &Field::update)
      .def("_limit", &Field::limit)
      .def("_potential", &Field::potential)
      .def("_labels", &Field::labels);
}

}  // namespace mesh_map
