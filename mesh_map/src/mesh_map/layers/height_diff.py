"""Height differences: steps that a robot cannot climb."""

from typing import TYPE_CHECKING

import numpy as np

from mesh_map import _kernels
from mesh_map.parameter import Parameter
from mesh_map.threshold_layer import ThresholdLayer

if TYPE_CHECKING:
    from mesh_map.mesh_map import MeshMap


class HeightDiffLayer(ThresholdLayer):
    """max z - min z, in meters, over a vertex and those around it within a radius.

    "Around" means: reached over edges through vertices whose Euclidean distance from the vertex is
    below the radius. The vertex itself counts; in the released mesh_map it did not, and a vertex
    without neighbors in reach had -inf.
    """

    PARAMETERS = (
        Parameter("threshold", 0.185, 0.05, 1.0, "lethal above, in meters", affects_costs=False),
        Parameter("radius", 0.3, 0.02, 1.0, "radius of the neighborhood in meters"),
    )

    def compute_costs(self, mesh_map: "MeshMap") -> np.ndarray:
        return _kernels._height_difference(
            mesh_map.vertices,
            mesh_map.topology.neighbor_offsets,
            mesh_map.topology.neighbors,
            self.params["radius"],
        )
