"""Costs of another layer, smoothed over the surface."""

from typing import TYPE_CHECKING, Mapping, Optional, Tuple

import numpy as np
from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Layer, LayerInput, LayerResult

if TYPE_CHECKING:
    from mesh_map.geometry.topology import Topology
    from mesh_map.map.mesh_map import MeshMap


class SmoothLayer(Layer):
    """The costs of one other layer, each mixed with the mean of those of its neighbors.

    Noise of the sensor makes costs such as roughness jump from vertex to vertex, and paths wind
    around single bad ones. What is lethal or unknown in the other layer stays so, and does not
    count for its neighbors.
    """

    # What users may set; see mesh_map.base.parameter. All layers have factor and
    # combination_weight, and those that read other layers have inputs.
    PARAMETERS = (
        Parameter("strength", 0.5, 0.0, 1.0, "share of the neighbors in a cost"),
        Parameter("rounds", 1, 1, 20, "how often: each reaches one edge farther"),
    )
    READS_LAYERS = True
    READS_WEIGHTS = False

    def compute(self, mesh_map: "MeshMap", inputs: Mapping[str, LayerInput]) -> LayerResult:
        """Everything."""
        costs = self._start(inputs)
        everywhere = np.arange(len(costs))
        for _ in range(self.params["rounds"]):
            costs[everywhere] = self._mixed(mesh_map.topology, costs, everywhere)
        return self._result(costs)

    def update(
        self,
        mesh_map: "MeshMap",
        inputs: Mapping[str, LayerInput],
        changed: np.ndarray,
        before: LayerResult,
    ) -> LayerResult:
        """Only what the changed vertices reach: the same as compute(), bit for bit."""
        topology, rounds = mesh_map.topology, self.params["rounds"]
        reached = _grown(topology, changed, rounds)
        # The last round changes these; the rounds before are also needed around them.
        zones = [reached]
        for _ in range(rounds - 1):
            zones.append(_grown(topology, zones[-1], 1))
        if len(zones[-1]) > len(mesh_map.vertices) // 4:
            return self.compute(mesh_map, inputs)  # is quicker then
        costs = self._start(inputs)
        for zone in reversed(zones):
            costs[zone] = self._mixed(topology, costs, zone)
        after = before.costs.copy()
        after[reached] = costs[reached]
        return self._result(after)

    def reuse(
        self, costs: np.ndarray, mesh_map: "MeshMap", inputs: Mapping[str, LayerInput]
    ) -> Optional[LayerResult]:
        """Costs from the map file, which were computed with the same parameters and input."""
        return self._result(costs)

    def _start(self, inputs: Mapping[str, LayerInput]) -> np.ndarray:
        """(V,) float64 costs of the input; +inf wherever it is lethal."""
        if len(inputs) != 1:
            raise MeshMapError(
                "it smooths one layer, but has the inputs: " + (", ".join(inputs) or "none"),
                "name one, such as inputs: [roughness]",
            )
        (read,) = inputs.values()
        costs = read.costs.astype(np.float64)
        costs[read.lethal] = np.inf
        return costs

    def _mixed(self, topology: "Topology", costs: np.ndarray, vertices: np.ndarray) -> np.ndarray:
        """Costs of some vertices after one more round."""
        rows, neighbors = _neighbors(topology, vertices)
        around = costs[neighbors]
        counting = np.isfinite(around)
        rows, around = rows[counting], around[counting]
        number = np.bincount(rows, minlength=len(vertices))
        total = np.bincount(rows, around, minlength=len(vertices))
        own = costs[vertices]
        mixing = np.isfinite(own) & (number > 0)
        share = self.params["strength"]
        mixed = own.copy()
        mixed[mixing] = (1.0 - share) * own[mixing] + share * (total[mixing] / number[mixing])
        return mixed

    @staticmethod
    def _result(costs: np.ndarray) -> LayerResult:
        return LayerResult(costs.astype(np.float32), np.isposinf(costs))


def _neighbors(topology: "Topology", vertices: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """All neighbors of vertices (K,), one after the other, and of which of the K each is one."""
    starts = topology.neighbor_offsets[vertices].astype(np.int64)
    counts = topology.neighbor_offsets[vertices + 1].astype(np.int64) - starts
    rows = np.repeat(np.arange(len(vertices)), counts)
    first = np.cumsum(counts) - counts
    return rows, topology.neighbors[np.arange(len(rows)) + (starts - first)[rows]]


def _grown(topology: "Topology", vertices: np.ndarray, rings: int) -> np.ndarray:
    """Vertices and all that a number of edges leads to from them, ascending."""
    found = vertices.astype(np.int64)
    for _ in range(rings):
        found = np.union1d(found, _neighbors(topology, found)[1])
    return found
