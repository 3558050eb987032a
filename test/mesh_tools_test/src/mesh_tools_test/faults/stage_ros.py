"""A hall with a robot, the navigation server and its guard, each a process, and what goes wrong."""

import contextlib
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable, Dict, Optional
from xmlrpc.client import ServerProxy

import numpy as np
import rosgraph
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_navigation import MeshNavigator
from mesh_navigation.client.navigation_result import NavigationError
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from mesh_tools_test.base.server_start import executable
from mesh_tools_test.demo.processes import process, roscore
from mesh_tools_test.driving.obstacles import RADIUS, SIZE, hall_layers, hall_mesh
from mesh_tools_test.driving.server_nodes import CLOUDS, ROBOT, SERVER
from mesh_tools_test.driving.worlds import layer
from mesh_tools_test.faults.record import Record

START, GOAL = (2.0, 6.0, 0.0), (6.0, 6.0, 0.0)
SPEED, ACCELERATION = 1.0, 1.0  # m/s and m/s^2, of the controller
ODOM_TIMEOUT, CLOUD_TIMEOUT, HELD = 0.3, 1.0, 8  # s
PATIENCE = 60.0  # s, for anything
_THICKNESS = 0.1  # m, of a wall
_SEEN = 1.0  # s, until the last cloud that shows a wall is in the map


class Valve:
    """Passes messages of one topic on to another, as long as it is open.

    Attributes:
        last: when the last one passed (s, monotonic).
    """

    def __init__(self, topic: str, kind: Any) -> None:
        self._lock, self._is_open, self.last = threading.Lock(), True, 0.0
        self._out = rospy.Publisher(topic, kind, queue_size=10, tcp_nodelay=True)
        self._in = rospy.Subscriber("/robot" + topic, kind, self._pass, queue_size=10)

    def _pass(self, message: Any) -> None:
        with self._lock:
            if self._is_open:
                self._out.publish(message)
                self.last = time.monotonic()

    def turn(self, is_open: bool) -> None:
        """Nothing passes after it is closed."""
        with self._lock:
            self._is_open = is_open


class Stage:
    """All of it; a context.

    Attributes:
        record: what the robot was told and where it was.
        tf, clouds: what the server gets of the robot's.
        notes: folder of files in which plugins note when they fail.
        wall_x: m, where a wall begins; inf where there is none.
    """

    def __init__(self, folder: Path, plugins: Path) -> None:
        """Args:
        folder: for the map and logs.
        plugins: the package faulty_plugins.
        """
        self._folder, self._plugins, self.notes = folder, plugins, folder
        self._stack = contextlib.ExitStack()
        self.wall_x = np.inf
        self._server: Any = None

    def __enter__(self) -> "Stage":
        with self._stack:
            self._open(self._stack.enter_context)
            self._stack = self._stack.pop_all()
        return self

    def __exit__(self, *error: Any) -> None:
        self._stack.close()

    def _open(self, enter: Callable[[Any], Any]) -> None:
        enter(roscore(self._folder))
        path = self._folder / "hall.h5"
        mesh = hall_mesh()
        MapFile.write(str(path), Mesh(vertices=mesh.vertices, faces=mesh.faces))
        rospy.set_param(SERVER, self._server_parameters(path))
        rospy.set_param(ROBOT, {"mesh_file": str(path), "initial_pose": [*START, 0.0]})
        record = self._folder / "record"
        record.touch()
        module = [sys.executable, "-m", "mesh_tools_test.faults.recorder_node"]
        enter(process("recorder", [*module, str(record)], self._folder))
        robot = [executable("mesh_navigation", "surface_robot"), "__name:=" + ROBOT[1:]]
        robot += ["/tf:=/robot/tf", CLOUDS + ":=/robot" + CLOUDS]
        enter(process("robot", robot, self._folder))
        self.start_server()
        rospy.init_node("faults", disable_signals=True)
        self._stack.callback(rospy.signal_shutdown, "measured")
        self.record = Record(record)
        self._stack.callback(self.record.close)
        self.tf, self.clouds = Valve("/tf", TFMessage), Valve(CLOUDS, PointCloud2)
        self._pose = rospy.Publisher("/initialpose", PoseWithCovarianceStamped, queue_size=1)
        self._markers = rospy.Publisher(ROBOT + "/obstacles", MarkerArray, queue_size=1)
        self.navigator = MeshNavigator(SERVER[1:], tell=lambda text: None)
        self.wait(lambda: connected(self._pose, self._markers), "a robot")

    def _server_parameters(self, path: Path) -> Dict[str, Any]:
        layers = hall_layers()
        layers[0]["params"].update(topic=CLOUDS, expected_update_rate=CLOUD_TIMEOUT)
        layers.append(layer("border", "Border"))
        failing = {"name": "failing", "type": "faulty/FailingLayer"}
        layers.append({**failing, "params": {"file": str(self.notes / "failing")}})
        mesh_map: Dict[str, Any] = {each["name"]: each["params"] for each in layers}
        mesh_map["layers"] = [{key: each[key] for key in ("name", "type")} for each in layers]
        return {
            "mesh_map": {**mesh_map, "mesh_file": str(path)},
            "planners": [
                {"name": "wave_front", "type": "wave_front_planner/WaveFrontPlanner"},
                {"name": "holding", "type": "faulty/HoldingPlanner"},
            ],
            "holding": {"file": str(self.notes / "holding"), "seconds": HELD},
            "controllers": [{"name": "blocking", "type": "faulty/BlockingController"}],
            "blocking": {
                "file": str(self.notes / "blocking"),
                "max_lin_velocity": SPEED,
                "max_lin_acceleration": ACCELERATION,
            },
            "odom_timeout": ODOM_TIMEOUT,
            "planner_frequency": 1.0,
            # So that goals are answered soon, and nothing but the goal moves the robot; a new guard
            # may take its time on a busy machine.
            "recovery_enabled": False,
            "tf_timeout": 10.0,
            "planner_patience": 10.0,
            "controller_patience": 10.0,
            "cmd_vel_ignored_tolerance": 60.0,
        }

    def start_server(self) -> None:
        """One more, after the one before has ended."""
        environment = dict(os.environ)
        sources = self._plugins / "src"
        for name, place in (("ROS_PACKAGE_PATH", self._plugins), ("PYTHONPATH", sources)):
            environment[name] = "%s:%s" % (place, environment[name])
        command = [executable("mesh_navigation", "mbf_mesh_nav"), "__name:=" + SERVER[1:]]
        self._server = self._stack.enter_context(
            process("server", command, self._folder, environment)
        )[1]

    def kill_server(self) -> None:
        """At once, as a lack of memory does."""
        self._server.kill()
        self._server.wait()

    def wait(
        self, condition: Callable[[], Any], what: Optional[str], seconds: float = PATIENCE
    ) -> Any:
        """As `wait_until`, with a record that goes on."""

        def updated() -> Any:
            self.record.update()
            return condition()

        return wait_until(updated, what, seconds)

    def reset(self) -> None:
        """The robot stands at the start, in an empty hall, and the server is ready."""
        self.navigator.wait_until_ready(timeout=PATIENCE)
        self.wait(self._is_heard, "the connections of the guard")
        self._markers.publish(MarkerArray(markers=[Marker(action=Marker.DELETEALL)]))
        if self.wall_x < np.inf:  # clouds that show it may still be under way
            self.wall_x, seen = np.inf, time.monotonic() + _SEEN
            self.wait(lambda: self.clouds.last > seen, "a cloud")
        self.wait(_clear_map, "an answer of the server, which has its map")
        pose = PoseWithCovarianceStamped()
        pose.header.frame_id = "map"
        position = pose.pose.pose.position
        position.x, position.y, position.z = START
        pose.pose.pose.orientation.w = 1.0
        self._pose.publish(pose)
        self.wait(
            lambda: np.hypot(*(self.record.position() - START[:2])) < 0.01, "the robot's start"
        )

    @staticmethod
    def guard() -> ServerProxy:
        """The node of the server's guard; OSError or MasterError where there is none."""
        return ServerProxy(rosgraph.Master("/faults").lookupNode(SERVER + "_velocity_guard"))

    def _is_heard(self) -> bool:
        """Whether robot and recorder get what the guard sends; a new one does not wait for long."""
        try:
            infos = self.guard().getBusInfo("/faults")[2]
        except (OSError, rosgraph.MasterError):
            return False
        return {info[1] for info in infos if info[4] == "/cmd_vel"} >= {ROBOT, "/recorder"}

    def put_wall(self, distance: float) -> None:
        """Across the hall, so far (m) before the middle of the robot."""
        self.record.update()
        self.wall_x = float(self.record.position()[0]) + distance
        wall = Marker(type=Marker.CUBE, ns="wall")
        wall.header.frame_id = "map"
        position, size = wall.pose.position, wall.scale
        position.x, position.y, position.z = self.wall_x + _THICKNESS / 2, SIZE / 2, 0.5
        wall.pose.orientation.w = 1.0
        size.x, size.y, size.z = _THICKNESS, SIZE, 1.0
        self._markers.publish(MarkerArray(markers=[wall]))

    def room(self, begin: float) -> float:
        """m that were left around the robot from that time on: to a wall, or the hall's border."""
        positions = self.record.positions(begin)
        gaps = np.concatenate([positions, SIZE - positions, self.wall_x - positions[:, :1]], axis=1)
        return float(gaps.min()) - RADIUS


def _clear_map() -> bool:
    """Whether there is a map, whose layers now forget what sensors have seen."""
    try:
        rospy.ServiceProxy(SERVER + "/clear_mesh", Empty)()
    except rospy.ServiceException:
        return False
    return True


class Goal:
    """One drive to the goal, from a thread of its own.

    Attributes:
        answer: name of the outcome; empty before.
        message: what the server said.
    """

    def __init__(self, navigator: MeshNavigator) -> None:
        self.answer = self.message = ""
        self._navigator = navigator
        self._thread = threading.Thread(target=self._drive, daemon=True)
        self._thread.start()

    def _drive(self) -> None:
        try:
            result = self._navigator.go_to(*GOAL, yaw=0.0)
            self.message, self.answer = result.message, result.name
        except NavigationError as error:
            self.message, self.answer = str(error), "NO SERVER"
        except rospy.ROSException:  # this process ends
            pass

    def end(self) -> None:
        """Cancel it where it still goes on."""
        while self._thread.is_alive():
            self._navigator.cancel()
            self._thread.join(1.0)
