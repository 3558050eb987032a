"""The Move Base Flex server on a mesh map."""

import sys
import time
from typing import Optional, Sequence

import rospy

from mesh_map.base.errors import MeshMapError
from mesh_map.ros.node_end import watch_end
from mesh_msgs.diagnostics_ros import ERROR, OK, WARN, Diagnostics, Status
from mesh_msgs.init_node import init_node, spin, until_shutdown
from mesh_msgs_hdf5.files.probe import check_node_path
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_navigation.base.clock_ros import RosClock
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.base.robot import STOP
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.server.map_gate import Ready
from mesh_navigation.server.plan_store import PlanStore
from mesh_navigation.server.robot_chain import AgeLimits
from mesh_navigation.server.ros.check_services_node import CheckServices
from mesh_navigation.server.ros.exe_path_node import ExePathServer
from mesh_navigation.server.ros.get_path_node import GetPathServer
from mesh_navigation.server.ros.localization_ros import Localization
from mesh_navigation.server.ros.move_base_node import MoveBaseServer
from mesh_navigation.server.ros.plan_topics_ros import PlanTopics
from mesh_navigation.server.ros.recovery_node import RecoveryServer
from mesh_navigation.server.ros.robot_ros import RobotRos
from mesh_navigation.server.ros.server_map_ros import ServerMap, map_text
from mesh_navigation.server.ros.server_values_ros import ServerValues, misspelled_names
from mesh_navigation.server.ros.slot_action_node import Parts
from mesh_navigation.server.ros.transforms_ros import Transforms
from mesh_navigation.server.ros.velocity_commands_ros import (
    DirectCommands,
    GuardedCommands,
    VelocityCommands,
)
from mesh_navigation.server.settled_memory import give_back_large_arrays, settle

SHUT_DOWN = "the server is shut down"
# s, from a shutdown to the last answer; then what was sent gets a moment to leave.
LAST_ANSWERS, LAST_MESSAGES = 2.0, 0.2
# s, after which Python lets another thread go on: a cycle of control does not wait for planners.
SWITCH_INTERVAL = 0.0001


class MbfServer:
    """The node: a map below ``~mesh_map``, plugins below their names, four actions, services.

    Actions exist at once, while the map is loaded in a thread.
    """

    def __init__(self) -> None:
        values = ServerValues()
        limits = AgeLimits(
            values["odom_frame"].lstrip("/"), values["odom_timeout"], values["map_timeout"]
        )
        localization = Localization(
            values["localization_topic"],
            values["localization_timeout"],
            values["localization_patience"],
        )
        robot_frame = values["robot_frame"]
        transforms = Transforms(
            values["tf_cache_time"],
            values["tf_timeout"],
            limits,
            robot_frame.lstrip("/"),
            localization,
        )
        robot = RobotRos(
            _velocity_commands(values),
            transforms,
            localization,
            robot_frame,
            values["tf_timeout"],
            values["odom_topic"],
        )
        given = rospy.get_param("~", {}) or {}
        shape, fault = RobotShape(), ""
        try:
            shape = RobotShape.of_parameters(given)
        except MeshMapError as error:
            fault = f"{error}: set it, and start the server again"
        self._complaints = []
        if shape.inscribed_radius == 0.0 and not shape.is_point:
            text = "footprint: the robot's origin is not inside, so that planners keep no distance"
            self._complaints.append(text)
            rospy.logwarn("parameter ~%s", text)
        self._map = loaded = ServerMap(values["wait_for_map"], self._begin, shape, fault)
        kinds = (loaded.planners, loaded.controllers, loaded.behaviors)
        for complaint in misspelled_names(given, kinds):
            self._complaints.append(complaint)
            rospy.logwarn("%s: %s", rospy.get_name(), complaint)
        self._parts = parts = Parts(
            loaded.planners,
            loaded.controllers,
            loaded.behaviors,
            loaded.gate,
            transforms,
            localization,
            robot,
            RosClock(),
            values,
            PlanStore(),
        )
        sub_goals = (
            GetPathServer(parts, PlanTopics(loaded.server).show),
            ExePathServer(parts),
            RecoveryServer(parts),
        )
        self._servers = [*sub_goals, MoveBaseServer(parts, *sub_goals)]
        self._checks = CheckServices(parts, given, shape)
        self._diagnostics = Diagnostics("navigation", self._status)
        rospy.on_shutdown(self._stop)

    def start(self) -> None:
        """Accept goals and begin to load the map."""
        for server in self._servers:
            server.start()
        name = rospy.get_name()
        parts = []
        for plugins in (self._map.planners, self._map.controllers, self._map.behaviors):
            parts.append(f"{plugins.kind.what}s " + (", ".join(plugins.names) or "none"))
        rospy.loginfo(
            "%s: %s; waiting for the map, then for goals on %s/{%s}/goal",
            name,
            "; ".join(parts),
            name.rstrip("/"),
            ",".join(server.name for server in self._servers),
        )
        self._map.gate.reload()

    def _begin(self, ready: Ready) -> None:
        """Before the first goal gets a new map."""
        self._parts.plans.clear()
        self._parts.robot.trail.clear()
        self._parts.robot.frame = ready.map.frame_id
        settle()
        rospy.loginfo(
            "%s: ready, %s; waiting for goals, and for TF from '%s' to '%s' (not for plans with a "
            "start)",
            rospy.get_name(),
            map_text(ready),
            self._parts.values["robot_frame"],
            ready.map.frame_id,
        )

    def _status(self) -> Status:
        """For /diagnostics; its value "ready": whether goals are begun, else they wait or fail."""
        try:
            ready = self._map.gate.now()
        except NotReady as error:
            level = ERROR if error.kind == "MAP_ERROR" else WARN
            return Status(level, error.message, {"ready": False})
        localized = self._parts.localization.look()
        if localized.lost:
            return Status(ERROR, localized.lost, {"ready": False})
        kinds = (ready.planners, ready.controllers, ready.behaviors)
        complaints = [
            *filter(None, [localized.doubt]),
            *self._complaints,
            *self._map.planners.complaints,
            *self._map.controllers.complaints,
            *self._map.behaviors.complaints,
            *(complaint for prepared in kinds for complaint in prepared.complaints),
        ]
        if complaints:
            return Status(WARN, "; ".join(complaints), {"ready": True})
        return Status(OK, f"ready, {map_text(ready)}", {"ready": True})

    def _stop(self) -> None:
        self._diagnostics.shutdown()
        self._map.stop(SHUT_DOWN)
        self._checks.stop(SHUT_DOWN)
        end = time.monotonic() + LAST_ANSWERS
        for server in reversed(self._servers):  # move_base first, or it would go on with a failure
            server.stop(SHUT_DOWN)
        for server in self._servers:
            server.join(max(0.0, end - time.monotonic()))
        self._parts.robot.drive(STOP)
        time.sleep(LAST_MESSAGES)


def _velocity_commands(values: ServerValues) -> VelocityCommands:
    if not values["velocity_guard"]:
        return DirectCommands()
    return GuardedCommands({"robot_frame": values["robot_frame"], **values.guard})


def _check_map_file() -> None:
    """End where no reload finds the file: its path begins where roslaunch runs nodes."""
    path = rospy.get_param("~mesh_map/mesh_file", "")
    try:
        check_node_path(path if isinstance(path, str) else "")
    except MapFileError as error:
        rospy.logfatal("the map cannot be loaded: %s", error)
        raise SystemExit(1) from error


def main(arguments: Optional[Sequence[str]] = None) -> None:
    """Run the node until it is shut down."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    give_back_large_arrays()
    init_node("mbf_mesh_nav", argv=arguments, about=__doc__, package="mesh_navigation")
    watch_end()
    with until_shutdown():
        _check_map_file()
        MbfServer().start()
    spin()
