"""Layers that combine others into one."""

import abc
from functools import reduce
from typing import Optional, Union

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.map.mesh_map import MeshMap

_BLOCK = 1 << 16  # vertices at a time, so that intermediate results stay in the cache

Vertices = Union[slice, np.ndarray]


class CombinationLayer(Layer):
    """Base of layers whose cost of a vertex depends on the costs of the inputs there alone.

    Lethal is what is lethal in any input, and has +inf; unknown (NaN) what is unknown in any input
    and lethal in none. Without inputs everything is free. In ROS 2's mesh_navigation, lethal
    vertices have a finite cost.
    """

    READS_LAYERS = True

    @abc.abstractmethod
    def combine_costs(self, inputs: Inputs, vertices: Vertices) -> np.ndarray:
        """Costs of some vertices, float64; of lethal ones any.

        Args:
            inputs: at least one.
            vertices: a slice or indices, as an index of arrays of all vertices.
        """

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        count = len(mesh_map.vertices)
        costs, lethal = np.zeros(count, np.float32), np.zeros(count, np.bool_)
        if inputs:
            for start in range(0, count, _BLOCK):
                self._fill(costs, lethal, inputs, slice(start, start + _BLOCK))
        return LayerResult(read_only(costs), lethal)

    def update(
        self, mesh_map: MeshMap, inputs: Inputs, changed: np.ndarray, before: LayerResult
    ) -> LayerResult:
        if len(changed) > len(before.costs) // 4:
            return self.compute(mesh_map, inputs)
        costs, lethal = before.costs.copy(), before.lethal.copy()
        if len(changed):
            self._fill(costs, lethal, inputs, changed)
        return LayerResult(read_only(costs), lethal)

    def reuse(self, costs: np.ndarray, mesh_map: MeshMap, inputs: Inputs) -> Optional[LayerResult]:
        return LayerResult(costs, np.isposinf(costs))

    def _fill(
        self, costs: np.ndarray, lethal: np.ndarray, inputs: Inputs, vertices: Vertices
    ) -> None:
        dead = np.zeros_like(lethal[vertices])
        for read in inputs.values():
            dead |= read.lethal[vertices]
        with np.errstate(invalid="ignore", over="ignore"):  # 0 * inf, which is lethal anyway
            combined = self.combine_costs(inputs, vertices)
            combined[dead] = np.inf
            costs[vertices] = combined
        lethal[vertices] = dead


class SumCombinationLayer(CombinationLayer):
    """Sum of combination_weight times cost over the inputs.

    Called AvgCombinationLayer in the mesh_navigation for ROS 2, though it is no average.
    """

    def combine_costs(self, inputs: Inputs, vertices: Vertices) -> np.ndarray:
        return sum(
            read.weight * read.costs[vertices].astype(np.float64) for read in inputs.values()
        )


class WeightedCombinationLayer(SumCombinationLayer):
    """Mean of the costs of the inputs, each with its combination_weight.

    0 where all weights are 0 (and nothing is lethal or unknown).
    """

    def combine_costs(self, inputs: Inputs, vertices: Vertices) -> np.ndarray:
        total = super().combine_costs(inputs, vertices)
        return total / (sum(read.weight for read in inputs.values()) or 1.0)


class MaxCombinationLayer(CombinationLayer):
    """The largest cost of the inputs, whatever their combination_weight."""

    READS_WEIGHTS = False

    def combine_costs(self, inputs: Inputs, vertices: Vertices) -> np.ndarray:
        costs = (read.costs[vertices].astype(np.float64) for read in inputs.values())
        return reduce(np.maximum, costs)
