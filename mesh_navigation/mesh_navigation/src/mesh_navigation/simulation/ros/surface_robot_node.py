"""The node surface_robot: a simulated robot on a map, driven by cmd_vel."""

import math
import queue
import sys
import time
from typing import Any, Callable, Mapping, Optional, Sequence

import rospy
from geometry_msgs.msg import Pose2D, PoseWithCovarianceStamped, Twist
from mesh_msgs_hdf5.files.probe import check_node_path
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs.init_node import init_node, spin, until_shutdown
from visualization_msgs.msg import MarkerArray

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import misspelled, read_parameters
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.seams import stitched_faces
from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros.parameter_server import ParameterServer
from mesh_msgs import arrays, validation
from mesh_msgs.diagnostics_ros import OK, WARN, Diagnostics, Status
from mesh_msgs.text import one_line

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import pose_from_message, velocity_of
from mesh_navigation.base.pose import Pose, vector_text
from mesh_navigation.simulation.obstacle_messages import ObstacleMarkers
from mesh_navigation.simulation.obstacles import is_within, read_obstacles
from mesh_navigation.simulation.parameters import CHANGING_PARAMETERS, PARAMETERS, check_frames
from mesh_navigation.simulation.placing import initial_pose, put_down
from mesh_navigation.simulation.robot_lidar import RobotLidar, lidar_model
from mesh_navigation.simulation.robot_messages import numbers_in
from mesh_navigation.simulation.ros.robot_topics_ros import RobotTopics
from mesh_navigation.simulation.ros.start_costs_ros import StartCosts
from mesh_navigation.simulation.ros.step_time_ros import step_time
from mesh_navigation.simulation.simulated_robot import SimulatedRobot
from mesh_navigation.simulation.surface_robot import SurfaceRobot
from mesh_navigation.simulation.wheels import BaseLimits
from mesh_navigation.surface.map_loading import load_map

SILENCE = 5.0  # s after a warning; a robot that tries again is stopped again
BUMPER = 0.1  # m above the surface, where obstacles stop the robot


class SurfaceRobotNode:
    """Lets time pass for a robot, and tells what happens. All of it in the thread of `run`; other
    threads leave jobs for it."""

    def __init__(self) -> None:
        """
        Raises:
            MeshMapError: frames that TF cannot connect.
        """
        self._values = _parameters()
        check_frames(self._values)
        obstacles, complaints = read_obstacles(rospy.get_param("~obstacles", []))
        for complaint in complaints:
            rospy.logerr("%s", complaint)
        self._markers = ObstacleMarkers(obstacles)
        self._jobs: "queue.SimpleQueue[Callable[[], None]]" = queue.SimpleQueue()
        self._stop = Cancellation()
        rospy.on_shutdown(self._stop.cancel)
        self._topics = RobotTopics(self._values)
        self._uuid = ""  # of the last mesh that came
        self._map: Optional[MeshMap] = None
        self._costs: Optional[StartCosts] = None  # as long as they are waited for
        self._waiting: Optional[MeshMap] = None  # for its costs
        self._robot: Optional[SimulatedRobot] = None
        self._lidar: Optional[RobotLidar] = None
        self._scan_left = 0.0
        self._obstruction, self._silent_until = "", 0.0
        self._diagnostics = Diagnostics("robot", self._status)
        self._server = ParameterServer(
            rospy.get_name(), CHANGING_PARAMETERS, self._values, self._change
        )

    def run(self) -> None:
        """Simulate until the node is shut down.

        Raises:
            MeshMapError: a file that is no map, or nothing to put a robot on.
        """
        values = self._values
        rospy.Subscriber("cmd_vel", Twist, self._on_command, queue_size=1)
        self._subscribe("initialpose", PoseWithCovarianceStamped, self._put)
        self._subscribe("~obstacles", MarkerArray, self._change_obstacles)
        self._subscribe("~odometry_jump", Pose2D, self._jump_odometry)
        if values["costs_topic"] and not len(values["initial_pose"]):
            self._costs = StartCosts(values["costs_topic"], lambda: self._jobs.put(self._begin))
        if values["mesh_file"]:
            try:
                check_node_path(values["mesh_file"])
            except MapFileError as error:
                raise MeshMapError(str(error)) from error
            only_ground = {"layers": [], "origin": values["origin"]}
            self._take_map(load_map(values["mesh_file"], only_ground, values["mesh_part"]))
        else:
            topic = rospy.resolve_name(values["mesh_topic"])
            rospy.Subscriber(topic, arrays.MeshGeometryStamped, self._on_mesh, queue_size=1)
            text = "%s: waiting for the map on %s (or set _mesh_file:=...)"
            rospy.loginfo(text, rospy.get_name(), topic)
        steps = step_time(values["rate"], values["publish_clock"], values["real_time_factor"])
        self._topics.tell_frames()
        while not rospy.is_shutdown():
            seconds, stamp = steps.wait(self._stop)
            if self._stop.canceled:
                return
            self._do_jobs()
            if self._robot is not None and self._lidar is not None:
                self._step(self._robot, self._lidar, seconds, stamp)
            steps.tell()

    def _status(self) -> Status:
        """For /diagnostics."""
        if self._map is None:
            what = "a map" if self._waiting is None else "the costs of the map"
            return Status(WARN, f"the robot waits for {what}")
        if self._obstruction:
            return Status(WARN, f"the robot does not get on: {self._obstruction}")
        return Status(OK, f"the robot is on a map of {len(self._map.faces)} faces")

    def _step(
        self, robot: SimulatedRobot, lidar: RobotLidar, seconds: float, stamp: rospy.Time
    ) -> None:
        robot.advance(seconds)
        self._topics.tell(robot.body, stamp)
        self._say_obstruction(robot.body.obstruction)
        lidar.follow(stamp.to_sec(), self._topics.sensor_pose(robot.body.pose))
        self._scan_left -= seconds
        if self._scan_left <= 0 and self._values["scan_rate"]:
            self._scan_left = max(0.0, self._scan_left + 1 / self._values["scan_rate"])
            if self._topics.cloud_is_wanted:
                scan = lidar.scan(self._markers.obstacles)
                if scan is not None:
                    self._topics.tell_cloud(scan, stamp - rospy.Duration(lidar.duration))

    def _say_obstruction(self, obstruction: str) -> None:
        now = time.monotonic()
        if obstruction and obstruction != self._obstruction and now >= self._silent_until:
            rospy.logwarn("%s: the robot does not get on: %s", rospy.get_name(), obstruction)
            self._silent_until = now + SILENCE
        self._obstruction = obstruction

    def _on_mesh(self, message: arrays.MeshGeometryStamped) -> None:
        """Leave each mesh that differs from the one before, as a map without layers."""
        try:
            findings = validation.mesh_geometry_stamped(message)
            if findings:
                raise ValueError(str(findings[0]))
            mesh, frame = message.mesh_geometry, message.header.frame_id.lstrip("/")
            faces = stitched_faces(mesh.vertices, mesh.faces)  # no seam of textures stops a robot
            geometry = MeshGeometry(mesh.vertices, faces, frame_id=frame, uuid=message.uuid)
            if geometry.uuid == self._uuid:
                return
            geometry.spatial_index, geometry.walker  # made here, not while the robot drives
            self._uuid = geometry.uuid
            mesh_map = MeshMap.of(geometry)
            self._jobs.put(lambda: self._take_other_map(mesh_map))
        except Exception as error:  # whatever is published there
            topic = rospy.resolve_name(self._values["mesh_topic"])
            rospy.logerr("the mesh on %s cannot be used: %s", topic, one_line(str(error)))

    def _take_other_map(self, mesh_map: MeshMap) -> None:
        try:
            self._take_map(mesh_map)
        except MeshMapError as error:
            rospy.logerr(
                "%s: the map on %s: %s", rospy.get_name(), self._values["mesh_topic"], error
            )

    def _begin(self) -> None:
        """Costs have come, perhaps those that are waited for."""
        if self._waiting is not None:
            self._take_other_map(self._waiting)

    def _take_map(self, mesh_map: MeshMap) -> None:
        values, costs = self._values, None
        check_frames(values, mesh_map.frame_id)
        if self._costs is not None:
            costs = self._costs.of(mesh_map)
            if costs is None:
                self._wait_for_costs(self._costs.topic, mesh_map)
                return
            self._costs.close()
            self._costs = self._waiting = None
        try:
            start = initial_pose(mesh_map, values["initial_pose"], costs)
        except MeshMapError as error:
            rospy.logerr("%s; the robot begins near the middle of the map", error)
            start = initial_pose(mesh_map)
        body = self._body(mesh_map, start)
        if self._robot is None:
            self._robot = SimulatedRobot(body, command_timeout=values["cmd_vel_timeout"])
        else:
            self._robot.body = body
        self._map = mesh_map
        self._lidar = self._made_lidar(mesh_map)
        self._topics.tell_markers(self._markers, mesh_map.frame_id)
        text = "%s: the robot is at %s on a map of %d faces; waiting for velocities on %s"
        place = vector_text(body.pose.position)
        name = rospy.resolve_name("cmd_vel")
        rospy.loginfo(text, rospy.get_name(), place, len(mesh_map.faces), name)

    def _made_lidar(self, mesh_map: MeshMap) -> RobotLidar:
        return RobotLidar(mesh_map, lidar_model(self._values), self._values["seed"] + 2)

    def _change(self, given: Mapping[str, Any]) -> Mapping[str, Any]:
        """Parameters of lidar and odometry, told by dynamic_reconfigure; all that are in force."""
        self._values, complaints = read_parameters(CHANGING_PARAMETERS, given, self._values)
        for complaint in complaints:
            rospy.logwarn("parameter ~%s", complaint)
        self._jobs.put(self._take_other_values)
        return self._values

    def _take_other_values(self) -> None:
        values = self._values
        if self._map is not None and self._robot is not None:
            self._lidar = self._made_lidar(self._map)
            self._robot.body.change_odometry(values["slip"], values["odometry_yaw_drift"])

    def _wait_for_costs(self, topic: str, mesh_map: MeshMap) -> None:
        if mesh_map is not self._waiting:
            text = "%s: waiting for the costs of the map on %s (or set _initial_pose:=[x, y])"
            rospy.loginfo(text, rospy.get_name(), topic)
        self._waiting = mesh_map

    def _body(self, mesh_map: MeshMap, start: Pose) -> SurfaceRobot:
        """A robot on a map; where the one before was, if there is surface there."""
        before = None if self._robot is None else self._robot.body.pose
        values = self._values

        def made(pose: Pose) -> SurfaceRobot:
            return SurfaceRobot(
                mesh_map,
                pose,
                seed=values["seed"],
                slip=values["slip"],
                noise=values["motion_noise"],
                odometry_noise=values["odometry_noise"],
                odometry_yaw_drift=values["odometry_yaw_drift"],
                limits=BaseLimits(*(values[f"max_{name}"] for name in BaseLimits._fields)),
                max_slope=values["max_slope"],
                max_step=values["max_step"],
                is_free=self._is_free,
            )

        if before is not None:
            try:
                return made(before)
            except MeshMapError as error:
                rospy.logwarn("%s: the map is another: %s", rospy.get_name(), error)
        return made(start)

    def _is_free(self, position: Any) -> bool:
        obstacles = self._markers.obstacles
        if not obstacles or self._map is None:
            return True
        return not is_within(obstacles, position + BUMPER * self._map.geometry.up)

    def _on_command(self, message: Twist) -> None:
        if self._robot is not None:
            self._robot.drive(velocity_of(message))

    def _put(self, message: PoseWithCovarianceStamped) -> None:
        if self._map is None or self._robot is None:
            rospy.logwarn("%s: initialpose is left out, there is no map yet", rospy.get_name())
            return
        frame = message.header.frame_id.lstrip("/")
        if frame != self._map.frame_id:
            text = "%s: initialpose is in the frame '%s', but '%s' is needed"
            rospy.logwarn(text, rospy.get_name(), frame, self._map.frame_id)
            return
        try:
            pose = pose_from_message(message.pose.pose)
            if pose.fault() is None:
                pose = put_down(self._map, pose)
            self._robot.put(pose)
            if self._lidar is not None:
                self._lidar.begin_anew()
        except MeshMapError as error:
            rospy.logwarn("%s: initialpose: %s", rospy.get_name(), error)

    def _jump_odometry(self, message: Pose2D) -> None:
        jump = message.x, message.y, message.theta
        if not all(map(math.isfinite, jump)):
            text = "%s: odometry_jump is left out, (%g, %g, %g) is not finite"
            rospy.logwarn(text, rospy.get_name(), *jump)
        elif self._robot is not None:
            self._robot.body.jump_odometry(*jump)

    def _change_obstacles(self, message: MarkerArray) -> None:
        frame = "map" if self._map is None else self._map.frame_id
        for complaint in self._markers.change(message, frame):
            rospy.logwarn("%s: %s", rospy.get_name(), complaint)
        self._topics.tell_markers(self._markers, frame)

    def _subscribe(self, name: str, message_type: Any, handle: Callable[[Any], None]) -> None:
        rospy.Subscriber(
            name, message_type, lambda message: self._jobs.put(lambda: handle(message))
        )

    def _do_jobs(self) -> None:
        while True:
            try:
                job = self._jobs.get_nowait()
            except queue.Empty:
                return
            job()


def _parameters() -> Mapping[str, Any]:
    given = dict(rospy.get_param("~", {}) or {})
    for name in {"initial_pose", "origin"}.intersection(given):
        given[name] = numbers_in(given[name])
    values, complaints = read_parameters(PARAMETERS, given)
    known = ["obstacles", *(parameter.name for parameter in PARAMETERS)]
    for complaint in complaints + misspelled(given, known):
        rospy.logwarn("parameter ~%s", complaint)
    return values


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the node until it is shut down; returns the exit code."""
    init_node("surface_robot", argv=arguments, about=__doc__, package="mesh_navigation")
    try:
        with until_shutdown():
            SurfaceRobotNode().run()
    except MeshMapError as error:
        sys.stderr.write("%s: error: %s\n" % (rospy.get_name(), error))
        return 1
    spin()  # The node is shut down: this says whether it failed.
    return 0
