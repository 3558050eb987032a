"""Shortest ways along edges as far as they are known, and how they follow changes."""

import operator
import threading
from typing import TYPE_CHECKING, Any, Iterable, Optional

import numpy as np

from mesh_map.array_checks import read_only
from mesh_map.cancel import CancelFlag, kernel_flag
from mesh_map.errors import Cancelled

if TYPE_CHECKING:
    from mesh_map.dijkstra import DijkstraSolver


class DijkstraField:
    """Distances from sources, as far as asked for. Made by DijkstraSolver.solve().

    It goes on where it stopped (extend), and follows changes of costs and weights (update). From
    any thread: whoever asks while it is being changed waits for that.
    """

    def __init__(self, solver: "DijkstraSolver", kernel: Any) -> None:
        self._solver = solver
        self._kernel = kernel
        self._lock = threading.Lock()
        self._potential: Optional[np.ndarray] = None
        self._predecessors: Optional[np.ndarray] = None

    @property
    def solver(self) -> "DijkstraSolver":
        """The one with the weights of the edges."""
        return self._solver

    @property
    def limit(self) -> float:
        """All distances up to this one are final; +inf where the field is complete."""
        with self._lock:
            return self._kernel._limit()

    @property
    def potential(self) -> np.ndarray:
        """(V,) float32, read-only: the distance to the nearest source in the unit of the weights.

        +inf where not reached, or not final. The array keeps what it is; after changes there is
        another one.
        """
        with self._lock:
            if self._potential is None:
                self._potential = read_only(self._kernel._potential())
            return self._potential

    @property
    def predecessors(self) -> np.ndarray:
        """(V,) uint32, read-only: the next vertex on the way to the nearest source.

        The vertex itself at a source, and where not reached.
        """
        with self._lock:
            if self._predecessors is None:
                self._predecessors = read_only(self._kernel._predecessors())
            return self._predecessors

    def reaches(self, vertices: Any) -> np.ndarray:
        """(N,) bool: which of these vertices have a final and finite distance.

        Raises:
            ValueError: a vertex that does not exist.
        """
        wanted = self._solver.indices(vertices, "")
        with self._lock:
            return self._kernel._reaches(wanted)

    def way_from(self, vertex: int) -> np.ndarray:
        """The vertices from this one to the source that it is nearest to, (N,) uint32.

        Empty if it was not reached.

        Raises:
            ValueError: a vertex that does not exist.
        """
        start = self._solver.indices([operator.index(vertex)], "")[0]
        with self._lock:
            return self._kernel._way_from(int(start))

    def extend(
        self,
        targets: Optional[Iterable[int]] = None,
        *,
        offset: float = 0.0,
        max_distance: float = float("inf"),
        cancel: Optional[CancelFlag] = None,
    ) -> None:
        """Goes on where it stopped; what is known already costs nothing.

        Args:
            targets, offset, max_distance: how far, as for DijkstraSolver.solve().
            cancel: ends this when it is set.
        Raises:
            ValueError: a vertex that does not exist, or a number out of its range.
            Cancelled: `cancel` was set. What was found until then is kept.
        """
        wanted = self._solver.indices(() if targets is None else targets, "target ")
        with self._lock:
            before = self._kernel._limit()
            done = self._kernel._extend(
                wanted, float(offset), float(max_distance), kernel_flag(cancel)
            )
            if self._kernel._limit() != before:
                self._forget_arrays()
        if not done:
            raise Cancelled("the search was cancelled")

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
            Cancelled: `cancel` was set. The field has the new costs then, and `limit` tells how far
                it is known; extend() goes on.
        """
        if solver is not None:
            solver.check_same_topology(self._solver)
        costs = frozen(vertex_costs)
        flag = kernel_flag(cancel)
        with self._lock:
            if solver is None:
                solver = self._solver
            if changed is None:
                vertices = self._kernel._opened_or_closed(costs)
                weighted = solver.vertices_changed_since(self._solver)
                vertices = np.concatenate([vertices, weighted])
            else:
                vertices = solver.indices(changed, "changed ")
            arrays = self._potential, self._predecessors
            self._forget_arrays()
            done, count = self._kernel._update(solver._graph, costs, vertices, flag)
            self._solver = solver
            if done and count == 0:
                self._potential, self._predecessors = arrays
        if not done:
            raise Cancelled("the update of a field was cancelled")
        return count

    def _forget_arrays(self) -> None:
        self._potential = self._predecessors = None


def frozen(values: Optional[Any]) -> Any:
    """Numbers as float32 that nobody changes: as they are, or a copy."""
    if values is None:
        return None
    if isinstance(values, np.ndarray) and not values.flags.writeable:
        return np.ascontiguousarray(values, np.float32)
    return read_only(np.array(values, np.float32, order="C"))
