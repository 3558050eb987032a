"""What fields that spread from a goal have in common, whichever way they spread."""

import operator
import threading
from typing import Any, Iterable, List, Optional, Tuple

import numpy as np

from mesh_map.base.array_checks import read_only, vertex_indices
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import Canceled


class PotentialField:
    """The potential of a goal, as far as asked for; it goes on where it stopped.

    One writer at a time, others wait.
    """

    def __init__(self, kernel: Any, vertex_count: int) -> None:
        self._kernel = kernel
        self._vertex_count = vertex_count
        self._lock = threading.Lock()
        self._potential: Optional[np.ndarray] = None

    @property
    def limit(self) -> float:
        """All values up to this one are final; +inf when the field is complete.

        -1 while nothing is, as after an update that was cancelled.
        """
        with self._lock:
            return self._kernel._limit()

    @property
    def potential(self) -> np.ndarray:
        """(V,) float32, read-only: +inf where not reached, or not final.

        The array keeps what it is; after changes there is another one.
        """
        with self._lock:
            if self._potential is None:
                self._potential = read_only(self._kernel._potential())
            return self._potential

    def reaches(self, vertices: Any) -> np.ndarray:
        """(N,) bool: is the potential of these vertices final, and finite?

        Raises:
            ValueError: a vertex that does not exist.
        """
        return np.isfinite(self.potential[vertex_indices(vertices, self._vertex_count, "")])

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
            targets, offset, max_distance: how far, as for solve() of the solver.
            cancel: ends this when it is set.
        Raises:
            ValueError: a target that does not exist, or a number out of its range.
            Canceled: `cancel` was set. What is final still is, and it may go on.
        """
        wanted = vertex_indices(() if targets is None else targets, self._vertex_count, "target ")
        flag = kernel_flag(cancel)
        with self._lock:
            before = self._kernel._limit()
            try:
                done = self._kernel._extend(wanted, float(offset), float(max_distance), flag)
            finally:
                if self._kernel._limit() != before:
                    self._forget_arrays()
        if not done:
            raise Canceled("the search from the goal was cancelled")

    def _forget_arrays(self) -> None:
        """Those that were made of what is no longer so."""
        self._potential = None


def pairs_of(given: Any, name: str, kinds: str) -> List[Tuple[int, float]]:
    """Pairs of a vertex and the value that a field starts with there.

    Raises:
        ValueError: no such pairs (what has this name has to be one of the kinds), or none at all.
    """
    try:
        pairs = [(operator.index(vertex), float(value)) for vertex, value in given]
    except (TypeError, ValueError):
        raise ValueError("the %s has to be %s" % (name, kinds)) from None
    if not pairs:
        raise ValueError("there is no %s" % name)
    return pairs
