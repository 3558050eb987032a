"""Layers that make costs of what is in the map file, such as preferences and speed limits."""

import abc
import logging
import math
from typing import Any, Mapping, Optional, Tuple

import numpy as np
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.costs.lethal_rule import LethalRule
from mesh_map.map.attributes import vertex_costs
from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")

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
                stored = self.params["layer"] or self.name
                self._look_at(stored, contents.layer_parameters(stored))
                costs = self._costs(contents.vertex_costs(stored))
            else:
                values = contents.face_attribute(self.params["face_attribute"])
                costs = vertex_costs(self._costs(self._column(values)), mesh_map.topology)
        except MapFileError as error:
            raise MeshMapError(str(error)) from error
        return LayerResult(costs, self.lethal_of(costs))

    def reuse(self, costs: np.ndarray, mesh_map: MeshMap, inputs: Inputs) -> Optional[LayerResult]:
        return LayerResult(costs, self.lethal_of(costs))

    def _look_at(self, stored: str, made_with: Mapping[str, Any]) -> None:
        """Says what is odd about a stored layer with these parameters."""

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


class StoredLayer(FileLayer):
    """scale * value + offset, of a layer or face attribute in the map file, within limits.

    What is +inf in the file is lethal, and NaN (or -inf) unknown, whatever the scale. Preferences
    from 0 (avoid) to 1 (best) become costs with scale -1 and offset 1.
    """

    PARAMETERS = SOURCE_PARAMETERS + (
        Parameter("scale", 1.0, description="factor of the values"),
        Parameter("offset", 0.0, description="added to the scaled values"),
        Parameter("minimum", 0.0, 0.0, None, "smallest cost"),
        Parameter("maximum", math.inf, 0.0, math.inf, "largest cost that is not lethal"),
        Parameter(
            "threshold", math.inf, 0.0, math.inf, "costs above are lethal", affects_costs=False
        ),
    )

    def _look_at(self, stored: str, made_with: Mapping[str, Any]) -> None:
        if "type" in made_with and math.isinf(self.params["threshold"]):
            _LOG.warning(
                "layer %s: the stored values of %s are costs of a %s, in which only +inf is lethal "
                "now; set threshold, or list that type, which knows what is lethal in them",
                self.name,
                stored,
                made_with["type"],
            )

    def costs_of(self, values: np.ndarray) -> np.ndarray:
        params = self.params
        if params["minimum"] > params["maximum"]:
            raise MeshMapError("minimum is %(minimum)g, above maximum, %(maximum)g" % params)
        finite = np.where(np.isfinite(values), values, np.nan)
        scaled = params["scale"] * finite + params["offset"]
        limited = np.maximum(np.minimum(scaled, params["maximum"]), params["minimum"])
        return np.where(np.isposinf(values), math.inf, limited)

    def lethal_of(self, costs: np.ndarray) -> np.ndarray:
        return np.isposinf(costs) | self.lethal_rule().of(costs)

    def lethal_rule(self) -> LethalRule:
        return LethalRule(float(self.params["threshold"]))


class SpeedLimitLayer(FileLayer):
    """max_speed / v - 1 where the map file allows the speed v, in meters per second.

    This is the time that is lost on a meter, compared with driving at max_speed: with edge_weight
    mean and edge_cost_factor 1, weights of edges are travel times multiplied by max_speed, and a
    planner finds the fastest way. 0 where max_speed or more is allowed, such as +inf; lethal up
    to min_speed; NaN means default_speed if that is above 0, else unknown.
    """

    PARAMETERS = SOURCE_PARAMETERS + (
        Parameter("max_speed", 1.0, 0.01, 100.0, "of the robot, in m/s"),
        Parameter("min_speed", 0.0, 0.0, 100.0, "lethal up to this speed limit, in m/s"),
        Parameter("default_speed", 0.0, 0.0, 100.0, "where the file says none, in m/s; 0: unknown"),
    )

    def costs_of(self, values: np.ndarray) -> np.ndarray:
        if self.params["default_speed"] > 0.0:
            values = np.where(np.isnan(values), self.params["default_speed"], values)
        lethal = values <= np.float32(self.params["min_speed"])  # as values are stored
        slower = self.params["max_speed"] / np.where(lethal, 1.0, values) - 1.0
        return np.where(lethal, math.inf, np.maximum(slower, 0.0))
