"""Layers that measure something at each vertex and call what is above a threshold lethal."""

import abc
from typing import ClassVar, Optional

import numpy as np

from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap


class ThresholdLayer(Layer):
    """Base of such a layer, which depends on the geometry alone. It has a parameter "threshold"."""

    @abc.abstractmethod
    def compute_costs(self, mesh_map: MeshMap) -> np.ndarray:
        """(V,) float32."""

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        return self._with_lethal(self.compute_costs(mesh_map))

    def reuse(self, costs: np.ndarray, mesh_map: MeshMap, inputs: Inputs) -> Optional[LayerResult]:
        return self._with_lethal(costs)

    def _with_lethal(self, costs: np.ndarray) -> LayerResult:
        return LayerResult(costs, costs > np.float32(self.params["threshold"]))


class RadiusLayer(ThresholdLayer):
    """Base of one that measures what is around each vertex. It has a parameter "radius" too.

    Layers of the same radius share one pass over the mesh.
    """

    STATISTIC: ClassVar[
        str
    ]  # the method of mesh_map.geometry.radius_pass.RadiusPass that gives the costs

    def announce(self, geometry: MeshGeometry) -> None:
        geometry.radius_pass(self.params["radius"]).request(self.STATISTIC)

    def compute_costs(self, mesh_map: MeshMap) -> np.ndarray:
        radius_pass = mesh_map.geometry.radius_pass(self.params["radius"])
        return getattr(radius_pass, self.STATISTIC)()
