"""dynamic_reconfigure for the plugins of a server."""

from typing import Dict, Iterable, List, Mapping

import rospy

from mesh_map.base.errors import error_line
from mesh_map.base.parameter import Value
from mesh_map.ros.parameter_server import ParameterServer

from mesh_navigation.plugins.plugin import MeshPlugin


class PluginReconfigure:
    """A server for each plugin, below the plugin's name; new values count at once."""

    def __init__(self, namespace: str, plugins: Iterable[MeshPlugin]) -> None:
        """Starts them. A plugin whose parameters cannot be served is logged in one line, and the
        others go on.

        Args:
            namespace: of the node, resolved.
            plugins: ready for a map.
        """
        self._servers: List[ParameterServer] = []
        for plugin in plugins:
            try:
                self._servers.append(_server(f"{namespace.rstrip('/')}/{plugin.name}", plugin))
            except Exception as error:  # A stranger's parameters may be odd in any way.
                if not rospy.is_shutdown():
                    text = error_line(error)
                    rospy.logerr("plugin %s cannot be reconfigured: %s", plugin.name, text)

    def shutdown(self) -> None:
        """Ends all servers."""
        for server in self._servers:
            server.shutdown()


def _server(namespace: str, plugin: MeshPlugin) -> ParameterServer:
    def change(values: Dict[str, Value]) -> Mapping[str, Value]:
        for complaint in plugin.set_parameters(values) or ():
            rospy.logwarn("%s/%s", plugin.name, complaint)
        return plugin.values

    return ParameterServer(namespace, plugin.parameters, plugin.values, change)
