"""The weighted mean of other layers."""

from typing import Mapping

import numpy as np

from mesh_map.costs.layer import LayerInput
from mesh_map.layers.combination_layer import CombinationLayer, Vertices


class WeightedCombinationLayer(CombinationLayer):
    """Mean of the costs of the inputs, each with its combination_weight.

    0 where all weights are 0 (and nothing is lethal or unknown).
    """

    def combine_costs(self, inputs: Mapping[str, LayerInput], vertices: Vertices) -> np.ndarray:
        total = sum(
            read.weight * read.costs[vertices].astype(np.float64) for read in inputs.values()
        )
        return total / (sum(read.weight for read in inputs.values()) or 1.0)
