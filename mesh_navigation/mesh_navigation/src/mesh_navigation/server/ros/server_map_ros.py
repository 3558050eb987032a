"""The server's map, with the plugins that work on it; both can be loaded anew."""

import math
import threading
from contextlib import ExitStack
from functools import partial
from typing import Any, Callable, Dict, Mapping

import rospy
from std_srvs.srv import Trigger, TriggerResponse

from mesh_map.base.parameter import Value
from mesh_map.base.errors import MeshMapError
from mesh_map.ros import MeshMapServer
from mesh_map.ros.parameter_server import ParameterServer, serve

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.plugins.plugin import MeshPlugin
from mesh_navigation.plugins.plugin_list import (
    BEHAVIORS,
    CONTROLLERS,
    PLANNERS,
    PluginKind,
    PluginList,
    Prepared,
)
from mesh_navigation.server.map_gate import MapGate, Ready


class ServerMap:
    """The map below ``~mesh_map``, plugins below their names, and the service ``~reload_map``."""

    def __init__(
        self, wait: bool, on_ready: Callable[[Ready], None], shape: RobotShape, fault: str = ""
    ) -> None:
        """
        Args:
            wait: whether goals wait for the map.
            on_ready: called with each new map before a goal gets it.
            shape: of the robot, for the plugins.
            fault: why there is no shape, and so no map for anybody; empty: there is one.
        """
        self._shape, self._fault = shape, fault
        self.planners = _plugins(PLANNERS)
        self.controllers = _plugins(CONTROLLERS)
        self.behaviors = _plugins(BEHAVIORS)
        radii = {"the robot's radius": shape.inscribed_radius}
        self.server = MeshMapServer("~mesh_map", radii)
        self.gate = MapGate(self._load, wait)
        self._on_ready = on_ready
        self._in_use = ExitStack()  # what works for the map
        self._ending = Cancellation()
        self._one_at_a_time = threading.Lock()
        self._service = rospy.Service("~reload_map", Trigger, self._reload)

    def stop(self, reason: str) -> None:
        """Let nobody wait for a map any longer."""
        self._ending.cancel(reason)

    def _load(self) -> Ready:
        try:
            self._in_use.close()
            if self._fault:
                raise MeshMapError(self._fault)
            self.server.load()
            ready = self._prepared()
            self._on_ready(ready)
        except Exception as error:
            # The end of the server ends the loading; rospy closes topics before it says so.
            if not (self._ending.canceled or rospy.is_shutdown()):
                rospy.logerr("no map, goals will fail: %s", error)
            raise
        return ready

    def _prepared(self) -> Ready:
        """New plugins; dynamic_reconfigure serves each below its name, new values count at once."""
        prepared = []
        body = Body(self.server.map.geometry, self._shape)
        for plugins in (self.planners, self.controllers, self.behaviors):
            given = {name: _dictionary(f"~{name}") for name in plugins.names}
            prepared.append(plugins.prepared(self.server.map, given, body))
            for complaint in prepared[-1].complaints:
                rospy.logwarn("%s", complaint)
            for plugin in prepared[-1].ready():
                server = partial(_parameter_server, plugin, partial(self._tell_limit, prepared[0]))
                serve(self._in_use, f"plugin {plugin.name}", server)
        self._tell_limit(prepared[0])
        return Ready(self.server.map, *prepared)

    def _tell_limit(self, planners: Prepared) -> None:
        """The cost limit of the planner that is used where a goal names none."""
        limits = (planner.values.get("cost_limit", math.nan) for planner in planners.ready())
        self.server.set_cost_limit(float(next(limits, math.nan)))

    def _reload(self, _request: Any) -> TriggerResponse:
        with self._one_at_a_time:
            rospy.loginfo("%s: the map is loaded anew", rospy.get_name())
            self.gate.reload()
            try:
                ready = self.gate.wait(self._ending, patient=True)
            except NotReady as error:
                return TriggerResponse(False, error.message)
        return TriggerResponse(True, map_text(ready))


def map_text(ready: Ready) -> str:
    """What map that is, as a phrase."""
    vertices, faces = len(ready.map.vertices), len(ready.map.faces)
    return f"map of {vertices} vertices and {faces} faces in frame '{ready.map.frame_id}'"


def _plugins(kind: PluginKind) -> PluginList:
    """Those that the user lists, or the default ones."""
    plugins = PluginList(kind, rospy.get_param(kind.parameter, None))
    for complaint in plugins.complaints:
        rospy.logerr("%s", complaint)
    return plugins


def _parameter_server(plugin: MeshPlugin, on_change: Callable[[], None]) -> ParameterServer:
    def change(values: Dict[str, Value]) -> Mapping[str, Value]:
        for complaint in plugin.set_parameters(values) or ():
            rospy.logwarn("%s/%s", plugin.name, complaint)
        on_change()
        return plugin.values

    namespace = f"{rospy.get_name().rstrip('/')}/{plugin.name}"
    return ParameterServer(namespace, plugin.parameters, plugin.values, change)


def _dictionary(name: str) -> Dict[str, Any]:
    """The parameters below a name; none if there is a single value of that name."""
    value = rospy.get_param(name, {})
    return value if isinstance(value, dict) else {}
