"""dynamic_reconfigure for the planners of a server."""

from typing import Dict, Iterable, List, Mapping

import rospy

from mesh_map.layer_list import error_line
from mesh_map.parameter import Value
from mesh_map.parameter_server_ros import ParameterServer

from mesh_navigation.planner import MeshPlanner


class PlannerReconfigure:
    """A server for each planner, below the planner's name; new values count from the next plan."""

    def __init__(self, namespace: str, planners: Iterable[MeshPlanner]) -> None:
        """Starts them. A planner whose parameters cannot be served is logged in one line, and the
        others go on.

        Args:
            namespace: of the node, resolved.
            planners: ready for a map.
        """
        self._servers: List[ParameterServer] = []
        for planner in planners:
            try:
                self._servers.append(_server(f"{namespace.rstrip('/')}/{planner.name}", planner))
            except Exception as error:  # A stranger's parameters may be odd in any way.
                if not rospy.is_shutdown():
                    text = error_line(error)
                    rospy.logerr("planner %s cannot be reconfigured: %s", planner.name, text)

    def shutdown(self) -> None:
        """Ends all servers."""
        for server in self._servers:
            server.shutdown()


def _server(namespace: str, planner: MeshPlanner) -> ParameterServer:
    def change(values: Dict[str, Value]) -> Mapping[str, Value]:
        for complaint in planner.set_parameters(values) or ():
            rospy.logwarn("%s/%s", planner.name, complaint)
        return planner.values

    return ParameterServer(namespace, planner.parameters, planner.values, change)
