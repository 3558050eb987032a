"""Layers that make costs of what is in the map file."""

import abc
from typing import Any, Optional, Tuple

import numpy as np
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.map.attributes import vertex_costs
from mesh_map.map.mesh_map import MeshMap

SOURCE_PARAMETERS: Tuple[Parameter, ...] = (
    Parameter("layer", "", description="stored layer to read; empty: that of this layer's name"),
    Parameter("face_attribute", "", description="attribute of faces to read instead"),
    Parameter("column", 0, 0, None, "of a face attribute with several values for each face"),
)


class FileLayer(Layer):
    """Base of a layer that reads a stored layer or a face attribute and makes costs of its values.

    Costs of faces become those of vertices: the largest around, see vertex_costs(). PARAMETERS
    begin with SOURCE_PARAMETERS.

    Such layers are never stored in the map file: they would replace what they are made of.
    """

    STORABLE = False

    @abc.abstractmethod
    def costs_of(self, values: np.ndarray) -> np.ndarray:
        """(N,) costs of (N,) float64 values of vertices or faces; NaN is unknown."""

    def lethal_of(self, costs: np.ndarray) -> np.ndarray:
        """(V,) bool of (V,) float32 costs."""
        return np.isposinf(costs)

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        contents = contents_of(mesh_map)
        try:
            if not self.params["face_attribute"]:
                costs = self._costs(contents.vertex_costs(self.params["layer"] or self.name))
            else:
                values = contents.face_attribute(self.params["face_attribute"])
                costs = vertex_costs(self._costs(self._column(values)), mesh_map.topology)
        except MapFileError as error:
            raise MeshMapError(str(error)) from error
        return LayerResult(costs, self.lethal_of(costs))

    def reuse(self, costs: np.ndarray, mesh_map: MeshMap, inputs: Inputs) -> Optional[LayerResult]:
        return LayerResult(costs, self.lethal_of(costs))

    def _costs(self, values: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore"):  # what does not fit is lethal
            return self.costs_of(values.astype(np.float64)).astype(np.float32)

    def _column(self, values: np.ndarray) -> np.ndarray:
        columns = values.reshape(len(values), -1)
        column = self.params["column"]
        if column >= columns.shape[1]:
            raise MeshMapError(
                "face attribute %s has no column %d" % (self.params["face_attribute"], column),
                "its columns are 0 to %d" % (columns.shape[1] - 1),
            )
        return columns[:, column]


def contents_of(mesh_map: MeshMap) -> Any:
    """What is in the file of a map.

    Raises:
        MeshMapError: it was not made from a file.
    """
    if mesh_map.contents is None:
        raise MeshMapError("the map was not read from a file, which this layer reads")
    return mesh_map.contents
