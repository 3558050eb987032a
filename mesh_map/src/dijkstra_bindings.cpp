#include "dijkstra_bindings.h"

#include <mesh_map/dijkstra.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "array_checks.h"
#include "cancel_flag.h"
#include "dijkstra_labels.h"

namespace mesh_map {
namespace {

using Array = const py::array&;

std::shared_ptr<DijkstraGraph> makeGraph(Array offsets, Array neighbors, Array neighbor_edges,
                                         Array edge_weights)
{
  const auto weights = view<float>(edge_weights, "edge_lengths", {ANY});
  const auto vertex_count = static_cast<std::size_t>(offsets.size() - (offsets.size() > 0));
  const RowsView rows = rowsView(offsets, neighbors, vertex_count, "neighbors");
  const auto edges = view<std::uint32_t>(neighbor_edges, "neighbor_edges", {neighbors.size()});
  checkIndices(edges, weights.size(), "neighbor_edges");
  const py::gil_scoped_release release;
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
  const py::gil_scoped_release release;
  return self.withWeights(weights.edges, weights.before, weights.after);
}

py::array changedVertices(Array edges, Array before, Array after)
{
  const EdgeWeights weights(edges, before, after);
  std::vector<std::uint32_t> vertices;
  {
    const py::gil_scoped_release release;
    vertices = verticesAtChanges(weights.edges, weights.before, weights.after);
  }
  return toArray(std::move(vertices));
}

bool lengthsOrClosed(Array weights, Array lengths)
{
  const auto values = view<float>(weights, "edge weights", {ANY});
  const auto expected = view<float>(lengths, "edge lengths", {weights.size()});
  const py::gil_scoped_release release;
  return areLengthsOrClosed(values, expected);
}

DijkstraQueue parseQueue(const std::string& name)
{
  if (name == "automatic") {
    return DijkstraQueue::AUTOMATIC;
  }
  if (name == "buckets") {
    return DijkstraQueue::BUCKETS;
  }
  if (name == "heap") {
    return DijkstraQueue::HEAP;
  }
  throw std::invalid_argument("queue has to be automatic, buckets or heap");
}

const std::atomic<bool>* flagOf(const CancelFlag* cancel)
{
  return cancel == nullptr ? nullptr : &cancel->flag;
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
    const py::gil_scoped_release release;
    field_ = std::make_unique<DijkstraField>(std::move(graph), std::move(pool), vertices, distances,
                                             vertex_costs);
  }

  bool extend(Array targets, float offset, float max_distance, const CancelFlag* cancel,
              const std::string& queue)
  {
    DijkstraReach reach;
    reach.targets = view<std::uint32_t>(targets, "targets", {ANY});
    reach.offset = offset;
    reach.max_distance = max_distance;
    const py::gil_scoped_release release;
    return field_->extend(reach, flagOf(cancel), parseQueue(queue));
  }

  py::tuple update(std::shared_ptr<DijkstraGraph> graph, const py::object& costs, Array changed,
                   const CancelFlag* cancel)
  {
    const VertexCosts vertex_costs = costsView(costs, field_->costs().limit, field_->vertexCount());
    const auto vertices = view<std::uint32_t>(changed, "changed", {ANY});
    kept_costs_ = py::make_tuple(kept_costs_, costs);  // whichever it looks at after an exception
    bool done = false;
    std::size_t count = 0;
    {
      const py::gil_scoped_release release;
      done = field_->update(std::move(graph), vertex_costs, vertices, count, flagOf(cancel));
    }
    kept_costs_ = costs;
    return py::make_tuple(done, count);
  }

  /// The vertices that may be passed with one of the costs, and not with the other.
  py::array openedOrClosed(const py::object& costs) const
  {
    const VertexCosts& before = field_->costs();
    const VertexCosts after = costsView(costs, before.limit, field_->vertexCount());
    std::vector<std::uint32_t> vertices;
    {
      const py::gil_scoped_release release;
      for (std::uint32_t v = 0; v < field_->vertexCount(); ++v) {
        if (before.isPassable(v) != after.isPassable(v)) {
          vertices.push_back(v);
        }
      }
    }
    return toArray(std::move(vertices));
  }

  py::array potential() const
  {
    std::vector<float> values(field_->vertexCount());
    {
      const py::gil_scoped_release release;
      field_->writePotential(values.data());
    }
    return toArray(std::move(values));
  }

  py::array predecessors() const
  {
    std::vector<std::uint32_t> values(field_->vertexCount());
    {
      const py::gil_scoped_release release;
      field_->writePredecessors(values.data());
    }
    return toArray(std::move(values));
  }

  py::array reaches(Array vertices) const
  {
    const auto wanted = view<std::uint32_t>(vertices, "vertices", {ANY});
    checkIndices(wanted, field_->vertexCount(), "vertices");
    py::array_t<bool> result(vertices.size());
    bool* const values = result.mutable_data();
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      values[i] = field_->reaches(wanted[i]);
    }
    return result;
  }

  py::array wayFrom(std::uint32_t vertex) const { return toArray(field_->wayFrom(vertex)); }

  float limit() const { return field_->limit(); }

 private:
  static VertexCosts costsView(const py::object& costs, float limit, std::size_t vertex_count)
  {
    VertexCosts result;
    result.limit = limit;
    if (!costs.is_none()) {
      const auto size = static_cast<py::ssize_t>(vertex_count);
      result.values = view<float>(py::cast<py::array>(costs), "vertex_costs", {size});
    }
    return result;
  }

  py::object kept_costs_;
  std::unique_ptr<DijkstraField> field_;
};

}  // namespace

void bindDijkstra(pybind11::module& module)
{
  using py::arg;
  py::class_<DijkstraGraph, std::shared_ptr<DijkstraGraph>>(module, "_DijkstraGraph",
                                                            py::module_local())
      .def(py::init(&makeGraph), arg("offsets"), arg("neighbors"), arg("neighbor_edges"),
           arg("edge_lengths"))
      .def("_with_weights", &graphWithWeights, arg("edges"), arg("before"), arg("after"));
  py::class_<DijkstraPool, std::shared_ptr<DijkstraPool>>(module, "_DijkstraPool",
                                                          py::module_local())
      .def(py::init(&makeDijkstraPool), arg("vertex_count"));
  py::class_<DijkstraKernel>(module, "_DijkstraField", py::module_local())
      .def(py::init<std::shared_ptr<DijkstraGraph>, std::shared_ptr<DijkstraPool>, const py::array&,
                    const py::array&, const py::object&, float>(),
           arg("graph"), arg("pool"), arg("sources"), arg("source_distances"), arg("vertex_costs"),
           arg("cost_limit"))
      .def("_extend", &DijkstraKernel::extend, arg("targets"), arg("offset"), arg("max_distance"),
           arg("cancel"), arg("queue") = "automatic")
      .def("_update", &DijkstraKernel::update, arg("graph"), arg("vertex_costs"), arg("changed"),
           arg("cancel"))
      .def("_opened_or_closed", &DijkstraKernel::openedOrClosed, arg("vertex_costs"))
      .def("_potential", &DijkstraKernel::potential)
      .def("_predecessors", &DijkstraKernel::predecessors)
      .def("_reaches", &DijkstraKernel::reaches, arg("vertices"))
      .def("_way_from", &DijkstraKernel::wayFrom, arg("vertex"))
      .def("_limit", &DijkstraKernel::limit);
  module.def("_vertices_at_changes", &changedVertices, arg("edges"), arg("before"), arg("after"));
  module.def("_are_lengths_or_closed", &lengthsOrClosed, arg("weights"), arg("lengths"));
}

}  // namespace mesh_map
