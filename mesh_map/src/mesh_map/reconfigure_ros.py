"""dynamic_reconfigure for a map and its layers."""

import dataclasses
import logging
from typing import Any, Callable, Dict, Iterable, List, Mapping

import rospy
from dynamic_reconfigure.encoding import decode_config, encode_config
from dynamic_reconfigure.server import Server

from mesh_map.layer_list import error_line
from mesh_map.mesh_map import MeshMap
from mesh_map.parameter import Parameter, Value
from mesh_map.reconfigure_type import ConfigType, is_described
from mesh_map.settings import SETTINGS

_LOG = logging.getLogger("mesh_map")

# Released configurations set them; nothing has ever depended on them.
WITHOUT_EFFECT = (
    Parameter("cost_limit", 1.0, 0.0, 10.0, "of release 1.x, without effect; planners have theirs"),
    Parameter("min_contour_size", 3, 0, 100000, "of release 1.x, without effect"),
)
MAP_PARAMETERS = SETTINGS + WITHOUT_EFFECT

Apply = Callable[[Dict[str, Value]], Mapping[str, Value]]


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
        self._servers: List[_Server] = [
            _Server(namespace, self._map_parameters(), own, self._set_map)
        ]
        for name, layer in mesh_map.layers.items():
            try:
                self._servers.append(
                    _Server(
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
        without_effect = dict(self._without_effect)
        for parameter in WITHOUT_EFFECT:
            if parameter.name in values:
                value, warning = parameter.checked(values.pop(parameter.name))
                without_effect[parameter.name] = value
                if warning:
                    _LOG.warning("%s", warning)
        if values:
            self._map.set_settings(**values)
        self._without_effect = without_effect
        return dict(without_effect, **dataclasses.asdict(self._map.settings))


class _Server(Server):
    """A server for declared parameters.

    What it is told is checked by who owns the parameters: a number out of its range is moved to the
    limit, and what cannot be used changes nothing, is logged in one line, and goes back to the
    values in force, which the caller and all others get.
    """

    def __init__(
        self,
        namespace: str,
        parameters: Iterable[Parameter],
        values: Mapping[str, Value],
        apply: Apply,
    ) -> None:
        """
        Args:
            namespace: where parameters, topics and the service are.
            parameters: those of a type that dynamic_reconfigure has are offered.
            values: what they are now.
            apply: gets changed values, and returns those in force; MeshMapError changes nothing.
        """
        self._namespace, self._apply = namespace, apply
        self._values = {p.name: values[p.name] for p in parameters if is_described(p)}
        super().__init__(ConfigType(parameters), self._changed, namespace)

    def shutdown(self) -> None:
        """Ends service and topics."""
        self.set_service.shutdown()
        self.descr_topic.unregister()
        self.update_topic.unregister()

    def _changed(self, config: Any, _level: int) -> Any:
        wanted = {name: config[name] for name in self._values if config[name] != self._values[name]}
        if wanted:
            try:
                in_force = self._apply(wanted)
                self._values = {name: in_force[name] for name in self._values}
            except Exception as error:  # any, of a stranger's layer
                _LOG.error("%s: refused: %s", self._namespace, error_line(error))
        config.update(self._values)
        return config

    def _set_callback(self, request: Any) -> Any:
        # The one group is not for clients to change, and names that they make up do not count.
        changes = decode_config(request.config)
        known = {name: changes[name] for name in changes if name in self._values}
        return encode_config(self.update_configuration(known))

    # The base class reads and writes one parameter after the other, each a question to the master,
    # takes what it finds for of the right type, and compares before anybody has checked.

    def _copy_from_parameter_server(self) -> None:
        self.config.update(self._values)

    def _copy_to_parameter_server(self) -> None:
        there = rospy.get_param(self._namespace, {})
        there = there if isinstance(there, dict) else {}
        for name, value in self._values.items():
            if there.get(name) != value:
                rospy.set_param("%s/%s" % (self._namespace.rstrip("/"), name), value)

    def _clamp(self, config: Any) -> None:
        """Whoever owns the parameters does it, and says so."""
