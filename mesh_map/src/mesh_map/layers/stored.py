"""Costs from layers and face attributes that are in the map file: preferences, speed limits."""

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.layers.file_layer import SOURCE_PARAMETERS, FileLayer

_INFINITE = float("inf")


class StoredLayer(FileLayer):
    """scale * value + offset, of a layer or face attribute in the map file, within limits.

    What is +inf in the file is lethal, and NaN (or -inf) unknown, whatever the scale. Preferences
    from 0 (avoid) to 1 (best) become costs with scale -1 and offset 1.
    """

    PARAMETERS = SOURCE_PARAMETERS + (
        Parameter("scale", 1.0, description="factor of the values"),
        Parameter("offset", 0.0, description="added to the scaled values"),
        Parameter("minimum", 0.0, 0.0, None, "smallest cost"),
        Parameter("maximum", _INFINITE, 0.0, _INFINITE, "largest cost that is not lethal"),
        Parameter(
            "threshold", _INFINITE, 0.0, _INFINITE, "costs above are lethal", affects_costs=False
        ),
    )

    def costs_of(self, values: np.ndarray) -> np.ndarray:
        params = self.params
        if params["minimum"] > params["maximum"]:
            raise MeshMapError("minimum is %(minimum)g, above maximum, %(maximum)g" % params)
        finite = np.where(np.isfinite(values), values, np.nan)
        scaled = params["scale"] * finite + params["offset"]
        limited = np.maximum(np.minimum(scaled, params["maximum"]), params["minimum"])
        return np.where(np.isposinf(values), _INFINITE, limited)

    def lethal_of(self, costs: np.ndarray) -> np.ndarray:
        return np.isposinf(costs) | (costs > np.float32(self.params["threshold"]))


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
        return np.where(lethal, _INFINITE, np.maximum(slower, 0.0))
