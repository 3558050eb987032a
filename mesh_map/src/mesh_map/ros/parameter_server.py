"""dynamic_reconfigure for parameters that are declared in Python."""

import logging
from contextlib import ExitStack
from typing import Any, Callable, Dict, Iterable, Mapping

import rospy
from dynamic_reconfigure.encoding import decode_config, encode_config
from dynamic_reconfigure.server import Server

from mesh_map.base.errors import PLUGIN_FAILURES, error_line
from mesh_map.base.parameter import Parameter, Value
from mesh_map.ros.reconfigure_type import ConfigType, is_described

_LOG = logging.getLogger("mesh_map")

Apply = Callable[[Dict[str, Value]], Mapping[str, Value]]


class ParameterServer(Server):
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
            except PLUGIN_FAILURES as error:
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


def serve(in_use: ExitStack, what: str, make: Callable[[], ParameterServer]) -> None:
    """Makes a server that ends with the stack.

    One that cannot be made (for an integer of more than 32 bits) is logged in one line.
    """
    try:
        in_use.callback(make().shutdown)
    except PLUGIN_FAILURES as error:  # a stranger's parameters may be odd in any way
        if not rospy.is_shutdown():
            _LOG.error("%s cannot be reconfigured: %s", what, error_line(error))
