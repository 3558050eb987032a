"""Which vertices may be passed at one moment, and how slow it is there."""

import threading
from functools import cached_property
from typing import List, Optional

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.geometry.mesh_geometry import MeshGeometry

from mesh_navigation.surface.up_normals import faces_around

# Where more than this share of the vertices has changed, a field is computed anew.
_MUCH = 1 / 8

# Those of the last few moments are kept: concurrent plans of one planner share them.
_KEPT = 2


def passable(costs: np.ndarray, cost_limit: float) -> np.ndarray:
    """(N,) bool: which costs may be passed. Lethal (+inf) and unknown (NaN) ones never."""
    return np.isfinite(costs) & (costs <= cost_limit)


class CostSnapshot:
    """The surface as one plan sees it: immutable, for any number of threads.

    Attributes:
        costs: (V,) float32 of the map.
        cost_limit: what costs more is not passed.
        cost_factor: a meter where the cost is c takes 1 + cost_factor c.
    """

    def __init__(
        self, geometry: MeshGeometry, costs: np.ndarray, cost_limit: float, cost_factor: float
    ) -> None:
        self._geometry = geometry
        self.costs = costs
        self.cost_limit = cost_limit
        self.cost_factor = cost_factor

    @cached_property
    def passable(self) -> np.ndarray:
        """(V,) bool, read-only."""
        return read_only(passable(self.costs, self.cost_limit))

    @cached_property
    def blocked_count(self) -> int:
        """How many vertices are not passable."""
        return len(self.costs) - int(np.count_nonzero(self.passable))

    @cached_property
    def is_length(self) -> bool:
        """Whether a meter takes 1 wherever it may be passed."""
        return not (self.cost_factor and np.any((self.costs > 0) & self.passable))

    @cached_property
    def slowness(self) -> Optional[np.ndarray]:
        """(V,) float32, read-only: how long a meter takes, +inf where it is not passable.

        None where it is 1 everywhere: searches are faster without an array of ones. No way may be
        shorter than it is: a negative cost counts as none.
        """
        if self.is_length and not self.blocked_count:
            return None
        if not self.is_length:
            with np.errstate(invalid="ignore"):
                slowness = 1 + np.float32(self.cost_factor) * np.maximum(self.costs, 0)
        else:
            slowness = np.ones(len(self.costs), dtype=np.float32)
        if self.blocked_count:
            slowness[~self.passable] = np.inf
        return read_only(slowness)

    @cached_property
    def open_faces(self) -> Optional[np.ndarray]:
        """(F,) bool, read-only: faces with three passable corners; None if these are all."""
        if not self.blocked_count:
            return None
        closed = np.flatnonzero(~self.passable)
        faces = self._geometry.faces
        if len(closed) > len(self.costs) // 8:
            return read_only(self.passable[faces].all(axis=1))
        mask = np.ones(len(faces), dtype=bool)
        mask[faces_around(self._geometry.topology, closed)[0]] = False
        return read_only(mask)


class CostSnapshots:
    """Those of one map; from any thread."""

    def __init__(self, geometry: MeshGeometry) -> None:
        self._geometry = geometry
        self._lock = threading.Lock()
        self._recent: List[CostSnapshot] = []

    def of(self, costs: np.ndarray, cost_limit: float, cost_factor: float = 0.0) -> CostSnapshot:
        """The same one as before while the costs are the same array and the numbers are equal."""
        with self._lock:
            for snapshot in self._recent:
                numbers = snapshot.cost_limit, snapshot.cost_factor
                if snapshot.costs is costs and numbers == (cost_limit, cost_factor):
                    return snapshot
            made = CostSnapshot(self._geometry, costs, cost_limit, cost_factor)
            self._recent = [made] + self._recent[: _KEPT - 1]
            return made


def changed_vertices(before: CostSnapshot, after: CostSnapshot) -> np.ndarray:
    """(K,) int64, ascending: where the slowness of two snapshots of one map differs."""
    if before.slowness is after.slowness:
        return np.zeros(0, dtype=np.int64)
    one = np.ones(1, dtype=np.float32)  # for every vertex
    arrays = [
        one if snapshot.slowness is None else snapshot.slowness for snapshot in (before, after)
    ]
    return np.flatnonzero(arrays[0] != arrays[1])


def is_much(changed: np.ndarray, snapshot: CostSnapshot) -> bool:
    """Whether so many vertices have changed that a field is better computed anew."""
    return len(changed) > _MUCH * len(snapshot.costs)
