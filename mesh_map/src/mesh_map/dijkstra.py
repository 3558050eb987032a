"""Shortest ways along the edges of a mesh."""

import operator
import threading
from dataclasses import dataclass
from typing import Any, Iterable, List, Optional, Tuple, Union

import numpy as np

from mesh_map import _kernels
from mesh_map.cancel import CancelFlag
from mesh_map.topology import Topology

Source = Union[int, Iterable[Tuple[int, float]]]


@dataclass(frozen=True, eq=False)
class DijkstraResult:
    """Distances from the sources.

    Attributes:
        potential: (V,) float32, distance to the nearest source in the unit of the edge lengths;
            +inf where not reached.
        predecessors: (V,) uint32, the next vertex on the way to that source; the vertex itself at a
            source and where not reached.
        cancelled: True if the solve was cancelled; the arrays are then incomplete and of no use.
    """

    potential: np.ndarray
    predecessors: np.ndarray
    cancelled: bool = False

    def way_from(self, vertex: int) -> np.ndarray:
        """The vertices from this one to the source that it is nearest to, (N,) uint32.

        Empty if it was not reached.

        Raises:
            ValueError: a vertex that does not exist.
        """
        vertex = operator.index(vertex)
        if not 0 <= vertex < len(self.potential):
            raise ValueError(
                "vertex %d does not exist: there are %d vertices" % (vertex, len(self.potential))
            )
        if not np.isfinite(self.potential[vertex]):
            return np.zeros(0, np.uint32)
        way: List[int] = [vertex]
        while self.predecessors[way[-1]] != way[-1]:
            way.append(int(self.predecessors[way[-1]]))
        return np.array(way, np.uint32)


class DijkstraSolver:
    """Dijkstra's algorithm on one mesh; for many solves, from any number of threads at once.

    Distances are sums of float32 edge lengths along the way from the source, rounded after each
    edge: bit for bit what a plain heap Dijkstra computes.
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
        self._vertex_count = topology.vertex_count
        lengths = np.ascontiguousarray(edge_lengths, np.float32)
        if lengths.shape != (topology.edge_count,):
            raise ValueError(
                "edge_lengths have the shape %s, but there are %d edges"
                % (lengths.shape, topology.edge_count)
            )
        self._graph = _kernels._DijkstraGraph(
            topology.neighbor_offsets, topology.neighbors, topology.neighbor_edges, lengths
        )
        self._running: List[CancelFlag] = []
        self._lock = threading.Lock()

    def solve(
        self,
        source: Source,
        vertex_costs: Optional[Any] = None,
        cost_limit: float = float("inf"),
        targets: Optional[Iterable[int]] = None,
        offset: float = 0.0,
        cancel_flag: Optional[CancelFlag] = None,
    ) -> DijkstraResult:
        """Distances from one vertex or several.

        Vertices that are lethal (+inf), unknown (NaN) or cost more than the limit are never passed:
        they are not reached, and as a source they start nothing.

        Args:
            source: a vertex, or pairs (vertex, distance to start with >= 0).
            vertex_costs: (V,) costs; None for none.
            cost_limit: the highest cost that is passed.
            targets: vertices; once all of them are reached, the field ends `offset` beyond the
                farthest of them, and what is farther counts as not reached. None for the whole
                field; so do targets that cannot be reached.
            offset: >= 0, in the unit of the edge lengths.
            cancel_flag: ends this solve when it is set.
        Raises:
            ValueError: a vertex that does not exist, a wrong number of costs, or a number out of
                its range.
        """
        vertices, distances = self._sources(source)
        flag = cancel_flag or CancelFlag()
        with self._lock:
            self._running.append(flag)
        try:
            potential, predecessors, cancelled = self._graph._solve(
                sources=vertices,
                source_distances=distances,
                vertex_costs=None
                if vertex_costs is None
                else np.ascontiguousarray(vertex_costs, np.float32),
                cost_limit=float(cost_limit),
                targets=self._indices(() if targets is None else targets, "target"),
                offset=float(offset),
                queue="automatic",
                cancel=flag._kernel,
            )
        finally:
            with self._lock:
                self._running.remove(flag)
        return DijkstraResult(potential, predecessors, cancelled)

    def cancel(self) -> None:
        """Ends every solve that runs now, by setting its flag; later ones without it go on."""
        with self._lock:
            for flag in self._running:
                flag.set()

    def _sources(self, source: Source) -> Tuple[np.ndarray, np.ndarray]:
        try:
            pairs = [(operator.index(source), 0.0)]  # type: ignore[arg-type]
        except TypeError:
            pairs = [(vertex, float(distance)) for vertex, distance in source]  # type: ignore
        if not pairs:
            raise ValueError("there is no source")
        vertices = self._indices((vertex for vertex, _ in pairs), "source")
        return vertices, np.array([distance for _, distance in pairs], np.float32)

    def _indices(self, vertices: Iterable[int], what: str) -> np.ndarray:
        indices = [operator.index(vertex) for vertex in vertices]
        for vertex in indices:
            if not 0 <= vertex < self._vertex_count:
                raise ValueError(
                    "%s vertex %d does not exist: there are %d vertices"
                    % (what, vertex, self._vertex_count)
                )
        return np.array(indices, np.uint32)
