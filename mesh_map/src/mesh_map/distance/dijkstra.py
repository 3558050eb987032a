"""Shortest ways along the edges of a mesh, and how they follow changes."""

import operator
from typing import Any, Iterable, Optional, Tuple, Union

import numpy as np

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only, vertex_indices
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import Canceled, Cancelled  # noqa: F401
from mesh_map.base.query_arguments import one_each
from mesh_map.distance.potential_field import PotentialField, pairs_of
from mesh_map.geometry.topology import Topology

Source = Union[int, Iterable[Tuple[int, float]]]


class DijkstraField(PotentialField):
    """Distances from sources, as far as asked for. Made by DijkstraSolver.solve().

    It goes on where it stopped (extend), and follows changes of costs and weights (update). From
    any thread: whoever asks while it is being changed waits for that. The potential is the distance
    to the nearest source, in the unit of the weights.

    Attributes:
        solver: the one with the weights of the edges.
    """

    def __init__(self, solver: "DijkstraSolver", kernel: Any) -> None:
        super().__init__(kernel, solver._topology.vertex_count)
        self.solver = solver
        self._predecessors: Optional[np.ndarray] = None

    @property
    def predecessors(self) -> np.ndarray:
        """(V,) uint32, read-only: the next vertex on the way to the nearest source.

        The vertex itself at a source, and where not reached.
        """
        with self._lock:
            if self._predecessors is None:
                self._predecessors = read_only(self._kernel._predecessors())
            return self._predecessors

    def way_from(self, vertex: int) -> np.ndarray:
        """The vertices from this one to the source that it is nearest to, (N,) uint32.

        Empty if it was not reached.

        Raises:
            ValueError: a vertex that does not exist.
        """
        start = self.solver.indices([operator.index(vertex)], "")[0]
        with self._lock:
            return self._kernel._way_from(int(start))

    def update(
        self,
        vertex_costs: Optional[Any],
        changed: Optional[Any] = None,
        *,
        solver: Optional["DijkstraSolver"] = None,
        cancel: Optional[CancelFlag] = None,
    ) -> int:
        """Follows a change of costs, of weights, or both: distances are bit for bit those of a
        new field. Of ways of the same length, it may know another one.

        Only what depends on the change is computed again, up to the same limit.

        Args:
            vertex_costs: (V,) new costs; None for none. The cost limit stays.
            changed: (K,) vertices; costs may differ only there, and weights only of edges that end
                there. None to find them by comparing everything, which takes about a millisecond
                per million vertices, and as much per million edges.
            solver: the one with the new weights, on the same topology (see
                DijkstraSolver.with_weights); None for the one that this field has.
            cancel: ends this when it is set.
        Returns:
            how many distances were taken back or looked at again; 0 if nothing has changed.
        Raises:
            ValueError: a wrong number of costs, a vertex that does not exist, or a solver of
                another topology: then nothing has changed.
            Canceled: `cancel` was set. The field has the new costs then, and `limit` tells how far
                it is known; extend() goes on.
        """
        if solver is not None and solver._topology is not self.solver._topology:
            raise ValueError("the solver is of another topology than the field")
        costs = frozen(vertex_costs)
        flag = kernel_flag(cancel)
        with self._lock:
            if solver is None:
                solver = self.solver
            if changed is None:
                vertices = self._kernel._opened_or_closed(costs)
                if solver is not self.solver:
                    edges, before = solver._topology.edges, self.solver.edge_lengths
                    weighted = _kernels._vertices_at_changes(edges, before, solver.edge_lengths)
                    vertices = np.concatenate([vertices, weighted])
            else:
                vertices = solver.indices(changed, "changed ")
            arrays = self._potential, self._predecessors
            self._forget_arrays()
            done, count = self._kernel._update(solver._graph, costs, vertices, flag)
            self.solver = solver
            if done and count == 0:
                self._potential, self._predecessors = arrays
        if not done:
            raise Canceled("the update of a field was cancelled")
        return count

    def _forget_arrays(self) -> None:
        super()._forget_arrays()
        self._predecessors = None


class DijkstraSolver:
    """Dijkstra's algorithm on one mesh; for many solves, from any number of threads at once.

    Dijkstra, A note on two problems in connexion with graphs, 1959; as planner: Pütz et al., 5.3.

    Distances are sums of float32 edge lengths along the way from the source, rounded after each
    edge: bit for bit what a plain heap Dijkstra computes.

    Attributes:
        edge_lengths: (E,) float32, read-only.
    """

    def __init__(self, *, topology: Topology, edge_lengths: Any) -> None:
        """Prepares the graph.

        Args:
            topology: of the mesh.
            edge_lengths: (E,) lengths or other weights, >= 0; +inf closes an edge.
        Raises:
            ValueError: a wrong number of lengths, or one that is NaN or negative (the first is
                named).
        """
        self._topology = topology
        self.edge_lengths = self._checked(edge_lengths)
        self._graph = _kernels._DijkstraGraph(
            topology.neighbor_offsets,
            topology.neighbors,
            topology.neighbor_edges,
            self.edge_lengths,
        )
        self._pool = _kernels._DijkstraPool(topology.vertex_count)

    def with_weights(self, edge_lengths: Any) -> "DijkstraSolver":
        """The same with other weights, for the price of a copy and of those that differ.

        Args, Raises: as for the constructor.
        """
        solver = object.__new__(DijkstraSolver)
        solver._topology = self._topology
        solver.edge_lengths = self._checked(edge_lengths)
        solver._graph = self._graph._with_weights(
            self._topology.edges, self.edge_lengths, solver.edge_lengths
        )
        solver._pool = self._pool
        return solver

    def solve(
        self,
        source: Source,
        vertex_costs: Optional[Any] = None,
        cost_limit: float = float("inf"),
        targets: Optional[Iterable[int]] = None,
        offset: float = 0.0,
        cancel_flag: Optional[CancelFlag] = None,
        *,
        max_distance: float = float("inf"),
    ) -> DijkstraField:
        """Distances from one vertex or several.

        Vertices that are lethal (+inf), unknown (NaN) or cost more than the limit are never passed:
        they are not reached, and as a source they start nothing.

        Args:
            source: a vertex, or pairs (vertex, distance to start with >= 0).
            vertex_costs: (V,) costs; None for none.
            cost_limit: the highest cost that is passed.
            targets: vertices; once all of them are reached, the field ends `offset` beyond the
                farthest of them, and what is farther counts as not reached. None, or an empty
                row, for the whole field; so do targets that cannot be reached.
            offset: >= 0, in the unit of the edge lengths.
            cancel_flag: ends this solve when it is set.
            max_distance: >= 0; the field ends there in any case.
        Raises:
            ValueError: a vertex that does not exist, a wrong number of costs, or a number out of
                its range.
            Canceled: `cancel_flag` was set.
        """
        vertices, distances = self._sources(source)
        costs = frozen(vertex_costs)
        kernel = _kernels._DijkstraField(
            self._graph, self._pool, vertices, distances, costs, float(cost_limit)
        )
        field = DijkstraField(self, kernel)
        field.extend(targets, offset=offset, max_distance=max_distance, cancel=cancel_flag)
        return field

    def _checked(self, edge_lengths: Any) -> np.ndarray:
        return one_each(frozen(edge_lengths), "edge_lengths", self._topology.edge_count, "edge")

    def _sources(self, source: Source) -> Tuple[np.ndarray, np.ndarray]:
        try:
            pairs = [(operator.index(source), 0.0)]  # type: ignore[arg-type]
        except TypeError:
            pairs = pairs_of(source, "source", "a vertex, or pairs of a vertex and a distance")
        vertices = self.indices([vertex for vertex, _ in pairs], "source ")
        with np.errstate(over="ignore"):  # +inf is refused
            return vertices, np.array([distance for _, distance in pairs], np.float32)

    def indices(self, vertices: Iterable[int], what: str) -> np.ndarray:
        """(N,) uint32 of these vertices, once they are known to exist.

        Raises:
            ValueError: one that does not (the first is named), after `what`; or no whole numbers.
        """
        return vertex_indices(vertices, self._topology.vertex_count, what)


def is_lengths_or_closed(weights: np.ndarray, lengths: np.ndarray) -> bool:
    """Whether each of the weights, (E,) float32, is the length of that edge or +inf."""
    return weights is lengths or _kernels._are_lengths_or_closed(weights, lengths)


def frozen(values: Optional[Any]) -> Any:
    """Numbers as float32 that nobody changes: as they are, or a copy."""
    if values is None:
        return None
    if isinstance(values, np.ndarray) and not values.flags.writeable:
        return np.ascontiguousarray(values, np.float32)
    return read_only(np.array(values, np.float32, order="C"))
