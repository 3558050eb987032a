"""Layers that measure something at each vertex and call what is above a threshold lethal."""

import abc
from typing import TYPE_CHECKING, Mapping, Optional

import numpy as np

from mesh_map.layer import Layer, LayerResult

if TYPE_CHECKING:
    from mesh_map.mesh_map import MeshMap


class ThresholdLayer(Layer):
    """Base of such a layer, which depends on the geometry alone. It has a parameter "threshold"."""

    @abc.abstractmethod
    def compute_costs(self, mesh_map: "MeshMap") -> np.ndarray:
        """(V,) float32."""

    def compute(self, mesh_map: "MeshMap", inputs: Mapping[str, LayerResult]) -> LayerResult:
        return self._with_lethal(self.compute_costs(mesh_map))

    def reuse(self, costs: np.ndarray) -> Optional[LayerResult]:
        return self._with_lethal(costs)

    def _with_lethal(self, costs: np.ndarray) -> LayerResult:
        return LayerResult(costs, costs > np.float32(self.params["threshold"]))
