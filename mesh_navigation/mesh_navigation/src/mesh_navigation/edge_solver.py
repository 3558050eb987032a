"""The solver that fits the costs of a map, with other weights only where these have changed."""

import threading
from typing import NamedTuple, Optional

import numpy as np

from mesh_map.dijkstra import DijkstraSolver, is_lengths_or_closed
from mesh_map.edge_weights import PlanningCosts
from mesh_map.mesh_map import MeshMap


class EdgeSolver(NamedTuple):
    """What one plan works with, all of one moment."""

    costs: np.ndarray
    """(V,) of the map."""
    solver: DijkstraSolver
    weighted: bool
    """Whether edges weigh other than their length (m), so that the potential is no distance."""


class EdgeSolvers:
    """Makes them for one map; may be used from several threads at once."""

    def __init__(self, mesh_map: MeshMap) -> None:
        self._map = mesh_map
        self._lock = threading.Lock()
        self._plain: Optional[DijkstraSolver] = None
        self._weights: Optional[np.ndarray] = None  # of the plan before
        self._solver: Optional[DijkstraSolver] = None  # for these

    def newest(self) -> EdgeSolver:
        """For the costs that the map has now."""
        return self.of(self._map.planning_costs())

    def of(self, snapshot: PlanningCosts) -> EdgeSolver:
        """For these costs.

        Edges of infinite weight end at vertices that are lethal or unknown, which a solver does not
        pass anyway. So where all others weigh what they are long, the one that knows lengths alone
        will do, and it is the same however often obstacles come and go.
        """
        with self._lock:
            weights = snapshot.edge_weights
            if self._weights is not weights:
                self._solver, self._weights = self._for(weights), weights
            return EdgeSolver(snapshot.costs, self._solver, self._solver is not self._plain)

    def _for(self, weights: np.ndarray) -> DijkstraSolver:
        lengths = self._map.geometry.edge_lengths
        if is_lengths_or_closed(weights, lengths):
            if self._plain is None:
                self._plain = self._made(lengths)
            return self._plain
        if self._solver is None or self._solver is self._plain:
            return self._made(weights)
        return self._solver.with_weights(weights)

    def _made(self, weights: np.ndarray) -> DijkstraSolver:
        return DijkstraSolver(topology=self._map.topology, edge_lengths=weights)
