"""dynamic_reconfigure for a map and its layers."""

import dataclasses
import logging
from typing import Dict, List, Mapping

from mesh_map.base.errors import error_line
from mesh_map.base.parameter import Parameter, Value, checked_values
from mesh_map.costs.settings import SETTINGS
from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros.parameter_server import ParameterServer

_LOG = logging.getLogger("mesh_map")

# Released configurations set them; nothing has ever depended on them.
WITHOUT_EFFECT = (
    Parameter("cost_limit", 1.0, 0.0, 10.0, "of release 1.x, without effect; planners have theirs"),
    Parameter("min_contour_size", 3, 0, 100000, "of release 1.x, without effect"),
)
MAP_PARAMETERS = SETTINGS + WITHOUT_EFFECT


class MapReconfigure:
    """One server at the namespace of the map, and one below it for each layer."""

    def __init__(self, namespace: str, mesh_map: MeshMap, values: Mapping[str, Value]) -> None:
        """Starts them. A layer with parameters that cannot be served (an integer of more than 32
        bits) is logged in one line, and the others go on.

        Args:
            namespace: of the map, resolved.
            mesh_map: its settings and layers are what is changed.
            values: of WITHOUT_EFFECT, checked.
        """
        self._map = mesh_map
        self._without_effect = {p.name: values[p.name] for p in WITHOUT_EFFECT}
        own = dict(self._without_effect, **dataclasses.asdict(mesh_map.settings))
        self._servers: List[ParameterServer] = [
            ParameterServer(namespace, self._map_parameters(), own, self._set_map)
        ]
        for name, layer in mesh_map.layers.items():
            try:
                self._servers.append(
                    ParameterServer(
                        "%s/%s" % (namespace.rstrip("/"), name),
                        layer.all_parameters(),
                        layer.params,
                        lambda values, name=name: mesh_map.set_layer_parameters(name, values),
                    )
                )
            except Exception as error:  # a stranger's parameters may be odd in any way
                _LOG.error("layer %s cannot be reconfigured: %s", name, error_line(error))

    def shutdown(self) -> None:
        """Ends all servers."""
        for server in self._servers:
            server.shutdown()

    def _map_parameters(self) -> List[Parameter]:
        layers = ("",) + tuple(self._map.layers)
        return [
            dataclasses.replace(parameter, choices=layers)
            if parameter.name == "default_layer"
            else parameter
            for parameter in MAP_PARAMETERS
        ]

    def _set_map(self, values: Dict[str, Value]) -> Mapping[str, Value]:
        own = {name: values.pop(name, before) for name, before in self._without_effect.items()}
        without_effect, warnings = checked_values(WITHOUT_EFFECT, own)
        for warning in warnings:
            _LOG.warning("%s", warning)
        if values:
            self._map.set_settings(**values)
        self._without_effect = without_effect
        return dict(without_effect, **dataclasses.asdict(self._map.settings))
