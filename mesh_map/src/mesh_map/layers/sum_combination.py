"""The weighted sum of other layers."""

from typing import Mapping

import numpy as np

from mesh_map.costs.layer import LayerInput
from mesh_map.layers.combination_layer import CombinationLayer, Vertices


class SumCombinationLayer(CombinationLayer):
    """Sum of combination_weight times cost over the inputs.

    Called AvgCombinationLayer in the mesh_navigation for ROS 2, though it is no average.
    """

    def combine_costs(self, inputs: Mapping[str, LayerInput], vertices: Vertices) -> np.ndarray:
        return sum(
            read.weight * read.costs[vertices].astype(np.float64) for read in inputs.values()
        )
