"""The Move Base Flex server on a mesh map."""

import threading
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

import rospy

from mesh_map.mesh_map import MeshMap
from mesh_map.parameter import Parameter, Value
from mesh_map.parameter_server_ros import ParameterServer
from mesh_map.ros import MeshMapServer
from mesh_msgs.init_node import init_node

from mesh_navigation.get_path_node import Ends, GetPathServer
from mesh_navigation.map_gate import MapGate
from mesh_navigation.parameters import changed_parameters, read_parameters
from mesh_navigation.plan_topics_ros import PlanTopics
from mesh_navigation.planner import PlanResult
from mesh_navigation.planner_list import DEFAULT_PLANNERS, PlannerList
from mesh_navigation.reconfigure_ros import PlannerReconfigure
from mesh_navigation.ros import Transforms

DYNAMIC_PARAMETERS = (
    Parameter("planner_patience", 5.0, 0.0, 100.0, "longest time for a plan (s), 0: no limit"),
    Parameter("planner_max_retries", -1, -1, 1000, "retries of a failed plan, -1: no limit"),
)
"""Those of the node that dynamic_reconfigure may change; they count from the next goal."""
PARAMETERS = DYNAMIC_PARAMETERS + (
    Parameter("robot_frame", "base_link", description="the robot's frame in TF"),
    Parameter("tf_timeout", 3.0, 0.0, None, "wait for a transform, and greatest age of it (s)"),
    Parameter("tf_cache_time", 10.0, 0.1, None, "how far TF is remembered (s)"),
    Parameter("wait_for_map", True, description="goals wait for the map; false: they fail"),
)
"""Parameters of the node itself, with default and limits."""


class MbfServer:
    """The node: a map below ``~mesh_map``, planners below their names, the action ``~get_path``.

    Actions exist at once, while the map is loaded in a thread.
    """

    def __init__(self) -> None:
        self._values, complaints = read_parameters(PARAMETERS, rospy.get_param("~", {}) or {})
        for complaint in complaints:
            rospy.logwarn("parameter ~%s", complaint)
        self._planners = PlannerList(rospy.get_param("~planners", DEFAULT_PLANNERS))
        for complaint in self._planners.complaints:
            rospy.logerr("%s", complaint)
        self._map_server = MeshMapServer("~mesh_map")
        self._gate = MapGate(self._load, self._values["wait_for_map"])
        transforms = Transforms(self._values["tf_cache_time"], self._values["tf_timeout"])
        self._get_path = GetPathServer(
            self._planners, self._gate, transforms, self._values, self._show
        )
        self._plan_topics = PlanTopics(self._map_server)
        self._to_show: Optional[Tuple[PlanResult, Optional[Ends]]] = None
        self._showing = threading.Lock()
        self._reconfigure = ParameterServer(
            rospy.get_name(), DYNAMIC_PARAMETERS, self._values, self._set
        )
        rospy.on_shutdown(self._get_path.stop)

    def start(self) -> None:
        """Accept goals and begin to load the map."""
        self._get_path.start()
        rospy.loginfo(
            "%s: planners %s; waiting for the map, then for goals on %s/get_path/goal",
            rospy.get_name(),
            ", ".join(self._planners.names) or "none",
            rospy.get_name(),
        )
        self._gate.start()

    def _set(self, values: Dict[str, Value]) -> Mapping[str, Value]:
        present = {parameter.name: self._values[parameter.name] for parameter in DYNAMIC_PARAMETERS}
        changed, complaints = changed_parameters(DYNAMIC_PARAMETERS, present, values)
        for complaint in complaints:
            rospy.logwarn("parameter ~%s", complaint)
        self._values.update(changed)
        return changed

    def _load(self) -> MeshMap:
        try:
            self._map_server.load()
            mesh_map = self._map_server.map
            given = {name: _dictionary(f"~{name}") for name in self._planners.names}
            for complaint in self._planners.initialize(mesh_map, given):
                rospy.logwarn("%s", complaint)
            self._planner_reconfigure = PlannerReconfigure(rospy.get_name(), self._planners.ready())
        except Exception as error:
            if not rospy.is_shutdown():  # which ends the loading
                rospy.logerr("no map, goals will fail: %s", error)
            raise
        rospy.loginfo(
            "%s: ready, map of %d vertices and %d faces; waiting for goals, those without a start "
            "also for TF from '%s' to '%s'",
            rospy.get_name(),
            len(mesh_map.vertices),
            len(mesh_map.faces),
            self._values["robot_frame"],
            mesh_map.frame_id,
        )
        return mesh_map

    def _show(self, result: PlanResult, mesh_map: MeshMap, ends: Optional[Ends]) -> None:
        # One at a time; of plans that wait for their turn (other slots'), only the last is shown.
        self._to_show = result, ends
        with self._showing:
            waiting, self._to_show = self._to_show, None
            if waiting is None:
                return
            result, ends = waiting
            self._plan_topics.show(result, mesh_map, ends)


def _dictionary(name: str) -> Dict[str, Any]:
    """The parameters below a name; none if there is a single value of that name."""
    value = rospy.get_param(name, {})
    return value if isinstance(value, dict) else {}


def main(arguments: Optional[Sequence[str]] = None) -> None:
    """Run the node until it is shut down."""
    init_node("mbf_mesh_nav", argv=arguments)
    try:
        server = MbfServer()
        server.start()
        rospy.spin()
    except rospy.ROSException:  # A signal during the start leaves parts undone: no error then.
        if not rospy.is_shutdown():
            raise
