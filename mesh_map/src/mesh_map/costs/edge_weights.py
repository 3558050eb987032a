"""Weights of edges from their lengths and the costs of their ends: what planners add up."""

import threading
from typing import Optional, Tuple

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.costs.settings import MapSettings
from mesh_map.geometry.mesh_geometry import MeshGeometry

_BLOCK = 1 << 16  # edges at a time, so that intermediate results stay in the cache


def mean_weights(lengths: np.ndarray, costs: np.ndarray, factor: float) -> np.ndarray:
    """length + factor length (cost_a + cost_b) / 2; +inf where a cost is lethal or unknown.

    As the later mesh_navigation (for ROS 2) has it: ways through costly regions are longer.

    Args:
        lengths: (N,) meters, >= 0.
        costs: (N, 2) of both ends.
        factor: edge_cost_factor, >= 0.
    Returns:
        (N,) float32.
    """
    costs = costs.astype(np.float64)
    weights = lengths * (1 + factor * (costs[:, 0] + costs[:, 1]) / 2) if factor else lengths
    return _float32(np.where(np.isfinite(costs).all(axis=1), weights, np.inf))


def difference_weights(lengths: np.ndarray, costs: np.ndarray, factor: float) -> np.ndarray:
    """length (1 + factor |cost_a - cost_b|); the length where a cost is lethal or unknown.

    As the first mesh_navigation has it: ways across changes of cost are longer, and those through a
    region of equal cost are not. Vertices that are lethal or unknown are the planner's to avoid.
    Arguments as for mean_weights(), factor: layer_factor.
    """
    costs = costs.astype(np.float64)
    with np.errstate(invalid="ignore"):
        weights = lengths * (1 + factor * np.abs(costs[:, 0] - costs[:, 1]))
    return _float32(np.where(np.isfinite(costs).all(axis=1), weights, lengths))


def _float32(weights: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        return weights.astype(np.float32)


class PlanningCosts:
    """What a planner needs of a map at one moment. Immutable.

    Attributes:
        version: a larger one whenever costs or weights have changed.
        costs: (V,) float32 of the map: >= 0, +inf lethal, NaN unknown.
    """

    def __init__(
        self,
        version: int,
        costs: np.ndarray,
        geometry: MeshGeometry,
        settings: MapSettings,
        before: Optional["PlanningCosts"] = None,
        changed: Optional[np.ndarray] = None,
    ) -> None:
        """Takes a snapshot.

        Args:
            version, costs: see above.
            geometry: of the map.
            settings: how weights are computed.
            before, changed: those before, from which this one differs in the costs of these
                vertices ((K,) ascending indices) and the version alone.
        """
        self.version = version
        self.costs = costs
        self._geometry = geometry
        self._settings = settings
        self._weights: Optional[np.ndarray] = None
        self._base: Optional[Tuple[np.ndarray, np.ndarray]] = None
        self._lock = threading.Lock()
        if before is not None and changed is not None:
            self._base = before._since(changed)

    @property
    def edge_weights(self) -> np.ndarray:
        """(E,) float32, of the edges of the topology: >= 0, +inf for an edge that is no way.

        Computed when first asked for; after a small change only where something has changed. The
        lengths themselves (the same array) where edge_weight is "difference" and layer_factor is 0.
        """
        with self._lock:
            if self._weights is None:
                self._weights = self._compute()
                self._base = None
            return self._weights

    def _since(self, changed: np.ndarray) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        """Weights that are known, and the vertices that have changed since; None for none."""
        # No lock: changes do not wait for a reader. In this order one of the two is seen.
        base, weights = self._base, self._weights
        if weights is not None:
            return weights, changed
        if base is None:
            return None
        return base[0], np.union1d(base[1], changed)

    def _compute(self) -> np.ndarray:
        lengths = self._geometry.edge_lengths
        edges = self._geometry.topology.edges
        settings = self._settings
        if settings.edge_weight == "mean":
            formula, factor = mean_weights, settings.edge_cost_factor
        else:
            formula, factor = difference_weights, settings.layer_factor
            if not factor:
                return lengths
        if self._base is None or len(self._base[1]) > len(self.costs) // 8:
            weights = np.zeros(len(edges), np.float32)
            for start in range(0, len(edges), _BLOCK):
                block = slice(start, start + _BLOCK)
                weights[block] = formula(lengths[block], self.costs[edges[block]], factor)
            return read_only(weights)
        weights, vertices = self._base
        if not len(vertices):
            return weights
        topology = self._geometry.topology
        touched = topology.neighbor_edges[topology.neighbor_places(vertices)]
        weights = weights.copy()
        weights[touched] = formula(lengths[touched], self.costs[edges[touched]], factor)
        return read_only(weights)
