"""Shortest ways along edges as far as they are known, and how they follow changes."""

import operator
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from mesh_map.array_checks import read_only
from mesh_map.cancel import CancelFlag, kernel_flag
from mesh_map.errors import Cancelled
from mesh_map.potential_field import PotentialField

if TYPE_CHECKING:
    from mesh_map.dijkstra import DijkstraSolver


class DijkstraField(PotentialField):
    """Distances from sources, as far as asked for. Made by DijkstraSolver.solve().

    It goes on where it stopped (extend), and follows changes of costs and weights (update). From
    any thread: whoever asks while it is being changed waits for that. The potential is the distance
    to the nearest source, in the unit of the weights.
    """

    def __init__(self, solver: "DijkstraSolver", kernel: Any) -> None:
        super().__init__(kernel, solver._topology.vertex_count)
        self._solver = solver
        self._predecessors: Optional[np.ndarray] = None

    @property
    def solver(self) -> "DijkstraSolver":
        """The one with the weights of the edges."""
        return self._solver

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
        start = self._solver.indices([operator.index(vertex)], "")[0]
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

    def _reached(self, wanted: np.ndarray) -> np.ndarray:
        return self._kernel._reaches(wanted)

    def _forget_arrays(self) -> None:
        super()._forget_arrays()
        self._predecessors = None


def frozen(values: Optional[Any]) -> Any:
    """Numbers as float32 that nobody changes: as they are, or a copy."""
    if values is None:
        return None
    if isinstance(values, np.ndarray) and not values.flags.writeable:
        return np.ascontiguousarray(values, np.float32)
    return read_only(np.array(values, np.float32, order="C"))
