"""The largest cost of other layers."""

from typing import Mapping

import numpy as np

from mesh_map.costs.layer import LayerInput
from mesh_map.layers.combination_layer import CombinationLayer, Vertices


class MaxCombinationLayer(CombinationLayer):
    """The largest cost of the inputs, whatever their combination_weight."""

    READS_WEIGHTS = False

    def combine_costs(self, inputs: Mapping[str, LayerInput], vertices: Vertices) -> np.ndarray:
        largest = None
        for read in inputs.values():
            costs = read.costs[vertices].astype(np.float64)
            largest = costs if largest is None else np.maximum(largest, costs)
        return largest
