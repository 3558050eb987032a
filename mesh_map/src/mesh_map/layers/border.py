"""Borders: where the surface ends, and a robot may fall off it."""


import numpy as np

from mesh_map.base.parameter import Parameter
from mesh_map.layers.threshold_layer import ThresholdLayer
from mesh_map.map.mesh_map import MeshMap


class BorderLayer(ThresholdLayer):
    """The border cost at vertices on an edge of only one face, else 0."""

    PARAMETERS = (
        Parameter("threshold", 0.5, 0.05, 1.0, "lethal above", affects_costs=False),
        Parameter("border_cost", 1.0, 0.02, 10.0, "cost of vertices on a border"),
    )

    def compute_costs(self, mesh_map: MeshMap) -> np.ndarray:
        topology = mesh_map.topology
        costs = np.zeros(topology.vertex_count, np.float32)
        costs[topology.edges[topology.border_edges]] = self.params["border_cost"]
        return costs
