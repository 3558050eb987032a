"""Steepness: slopes on which a robot slides or topples."""


import numpy as np

from mesh_map import _kernels
from mesh_map.base.parameter import Parameter
from mesh_map.layers.threshold_layer import ThresholdLayer
from mesh_map.map.mesh_map import MeshMap


class SteepnessLayer(ThresholdLayer):
    """The angle between the normal of a vertex and the up direction, in radians, 0 to pi.

    arccos(normal . up), as the SteepnessLayer of the released mesh_map.

    A map whose faces point down is steep everywhere, as in the released mesh_map, unless the map is
    told to orient them, or that down is up.
    """

    PARAMETERS = (
        Parameter("threshold", 0.3, 0.01, 3.1415, "lethal above, in radians", affects_costs=False),
    )

    def compute_costs(self, mesh_map: MeshMap) -> np.ndarray:
        return _kernels._angles_to(mesh_map.vertex_normals, mesh_map.geometry.up)
