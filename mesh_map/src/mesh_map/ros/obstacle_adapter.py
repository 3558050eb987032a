"""Point clouds from ROS for the layer of obstacles."""

import logging
import threading
import time
from typing import Any, Callable, Dict, Iterable, Optional, Set, Tuple

import numpy as np
import rospy
import tf2_ros
from mesh_msgs.text import one_line
from mesh_msgs.transform import TransformError, rotation_and_translation
from sensor_msgs.msg import LaserScan, PointCloud2
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from mesh_map.base.errors import MeshMapError, error_line
from mesh_map.geometry.topology import quantity
from mesh_map.io.point_cloud import cloud_points
from mesh_map.layers.observation_sources import LASER_SCAN, ObservationSource
from mesh_map.layers.obstacle import Transform
from mesh_map.layers.robot_outline import RobotOutline, listed_corners
from mesh_map.ros.complaints import ThrottledWarnings
from mesh_map.ros.ros_adapter import RosAdapter
from mesh_map.ros.transforms import SharedTransforms
from mesh_map.scans.laser_scan import scan_points

_LOG = logging.getLogger("mesh_map")
_PERIOD = 0.2  # seconds between two looks at what has become too old
_CLOSING_TIME = 2.0  # seconds
# With the last, rospy ends a wait for a transform when a bag begins again.
_UNUSABLE = (MeshMapError, TransformError, tf2_ros.TransformException, rospy.ROSException)
_BUFFER = 1 << 26  # bytes; with less, rospy keeps old clouds in the socket
_START = 3.0  # seconds after which it is logged that a source is silent
_NOTHING = "no point of it is finite"
_ROBOT_FRAME = "base_link"  # as the server has it


class ObstacleAdapter(RosAdapter):
    """Hands the clouds and scans of the layer's sources to it, and tells it when time passes.

    They are brought into the frame of the map by the transform of their stamp. The sensor is at the
    origin of their frame, or of the parameter sensor_frame. The newest one counts where they come
    faster than they can be used. Those that cannot be used are counted in one warning every ten
    seconds. Marks age by the ROS time at which messages arrive, so bags may be played with and
    without simulated time. A topic that is changed is subscribed to at once.

    While a source is silent, the map hears that the layer is not current. What the robot covers is
    cleared as the layer's parameters say, or footprint and robot_radius of a namespace around.

    Service: <namespace>/clear (std_srvs/Trigger) forgets all obstacles.
    """

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._lock = threading.Lock()  # held while the layer or the map changes
        self._due = False  # the layer has changed, and the map does not know it yet
        self._closed = threading.Event()
        self._complaints = ThrottledWarnings(self.layer.name)
        self._transforms = SharedTransforms.acquired()
        # Of each source: topic and type as they are subscribed to.
        self._subscribed: Dict[str, Tuple[str, str]] = {}
        self._unwatched: Set[str] = set()  # sources of which it is said that nobody watches them
        self._subscribers: Dict[str, rospy.Subscriber] = {}
        self._robot_frame = _parameter_around(self.namespace, "robot_frame", "")
        self.layer.body = self._body()
        self._spoke, self._complained = time.monotonic(), False
        self._service = rospy.Service(self.namespace + "/clear", Trigger, self._clear)
        self._subscribe()
        self.mesh_map.watch_data(self.layer.name, self._silence)
        self._thread = threading.Thread(target=self._run, name="obstacles", daemon=True)
        self._thread.start()

    def shutdown(self) -> None:
        """Ends subscription, service and thread.

        Waits for a change that is under way, but not forever: whoever calls may hold what that
        change is waiting for.
        """
        if self._closed.is_set():
            return
        self._closed.set()
        self._service.shutdown()
        if self._lock.acquire(timeout=_CLOSING_TIME):
            self._lock.release()
        if threading.current_thread() is not self._thread:
            self._thread.join(_CLOSING_TIME)
        for subscriber in self._subscribers.values():
            subscriber.unregister()
        self._transforms.release()

    def _subscribe(self) -> None:
        sources = {source.name: source for source in self.layer.sources}
        self._tell_unwatched(sources.values())
        wanted = {name: (one.topic, one.data_type) for name, one in sources.items()}
        if wanted == self._subscribed:
            return
        for name in list(self._subscribers):
            if self._subscribed[name] != wanted.get(name):
                self._subscribers.pop(name).unregister()
        reasons = []
        for name, source in sources.items():
            if not source.topic:
                reasons.append("the parameter topic is not set: no obstacles")
            elif name not in self._subscribers:
                try:
                    self._subscribers[name] = self._subscriber(source)
                except (ValueError, rospy.ROSException) as error:
                    reasons.append("no topic %r: %s" % (source.topic, one_line(error)))
        self._subscribed = wanted
        for reason in reasons:
            _LOG.error("layer %s: %s", self.layer.name, reason)
        self.mesh_map.set_without_data(self.layer.name, "; ".join(reasons))

    def _tell_unwatched(self, sources: Iterable[ObservationSource]) -> None:
        """Logs each source whose watch is switched off, once each time that is done."""
        unwatched = {one.name: one for one in sources if one.topic and not one.expected_update_rate}
        for name, source in unwatched.items():
            if name not in self._unwatched:
                text = "layer %s: nobody will notice when %s falls silent (%s is 0)"
                _LOG.warning(text, self.layer.name, source, "expected_update_rate")
        self._unwatched = set(unwatched)

    def _subscriber(self, source: ObservationSource) -> rospy.Subscriber:
        return rospy.Subscriber(
            source.topic,
            LaserScan if source.data_type == LASER_SCAN else PointCloud2,
            self._on_message,
            source.name,
            queue_size=1,
            buff_size=_BUFFER,
        )

    def _on_message(self, message: Any, name: str) -> None:
        """Called by rospy, in one thread for each publisher; name: of the source."""
        source = next((one for one in self.layer.sources if one.name == name), None)
        if source is None:
            return
        try:
            points, free = _points(message, source)
            frame, stamp = message.header.frame_id, message.header.stamp
            rotation, translation = self._to_map(frame, stamp)
            origin = self._sensor(source, frame, stamp)
            down = self._down(stamp)
        except _UNUSABLE as error:
            self._refuse(source, error)
            return
        with np.errstate(over="ignore", invalid="ignore"):
            points, free = (given @ rotation.T + translation for given in (points, free))
        if len(points) and not (len(free) or np.isfinite(points).all(axis=1).any()):
            self._refuse(source, _NOTHING)
        robot, now = self._robot(stamp), rospy.get_time()
        seen = stamp.to_sec() if stamp else now
        more = {"source": name, "free": free, "robot": robot, "down": down, "seen": seen}
        self._change(lambda: self.layer.insert_cloud(self.mesh_map, points, origin, now, **more))
        rospy.logdebug("layer %s: %s", self.layer.name, self.layer.last_cloud)

    def _refuse(self, source: ObservationSource, why: Any) -> None:
        """Says that a message cannot be used; it is none by which its source is heard."""
        if not rospy.is_shutdown():
            topic = rospy.resolve_name(source.topic)
            self._complaints.add("clouds from %s cannot be used" % topic, why)
            self.layer.missed(source.name, one_line(why))

    def _change(self, change: Callable[[], int]) -> None:
        with self._lock:
            if self._closed.is_set():
                return
            try:
                self._due = bool(change()) or self._due
                if self._due:
                    self.refresh()
                    self._due = False
            except Exception as error:  # of whatever depends on this layer; clouds go on
                self._complaints.add("obstacles cannot be taken over", error_line(error))

    def _to_map(self, frame: str, stamp: rospy.Time) -> Transform:
        """From a frame into that of the map."""
        frame, target = frame.lstrip("/"), self.mesh_map.frame_id.lstrip("/")
        if frame == target:
            return np.eye(3), np.zeros(3)
        if not frame:
            raise MeshMapError("a cloud has no frame_id")
        wait = rospy.Duration.from_sec(self.layer.params["tf_tolerance"])
        found = self._transforms.buffer.lookup_transform(target, frame, stamp, wait)
        return rotation_and_translation(found)

    def _sensor(self, source: ObservationSource, cloud_frame: str, stamp: rospy.Time) -> np.ndarray:
        """Where the sensor is, in the frame of the map."""
        frame = source.sensor_frame
        if not frame and cloud_frame.lstrip("/") == self.mesh_map.frame_id.lstrip("/"):
            self._complaints.add(
                "clouds are in the frame of the map, so the sensor seems to be at its origin",
                "set sensor_frame",
            )
        return self._to_map(frame or cloud_frame, stamp)[1]

    def _down(self, stamp: rospy.Time) -> Optional[np.ndarray]:
        """Down in the frame of the map; None for what the map says."""
        axis = self.layer.params["down_axis"]
        frame = self.layer.params["axis_frame"] or self._robot_frame
        if frame:
            return self._to_map(frame, stamp)[0] @ np.asarray(axis)
        default = next(p.default for p in self.layer.PARAMETERS if p.name == "down_axis")
        return None if tuple(axis) == tuple(default) else np.asarray(axis)

    def _robot(self, stamp: rospy.Time) -> Optional[Transform]:
        """Where the robot is whose outline is cleared; None where none is."""
        if not self.layer.outline:
            return None
        try:
            return self._to_map(self._robot_frame or _ROBOT_FRAME, stamp)
        except _UNUSABLE as error:
            self._complaints.add("what is under the robot cannot be cleared", error)
            return None

    def _body(self) -> RobotOutline:
        """What the parameters of a namespace around say that the robot covers."""
        corners, radius = (
            _parameter_around(self.namespace, name, otherwise)
            for name, otherwise in (("footprint", ()), ("robot_radius", 0.0))
        )
        try:
            return RobotOutline(listed_corners(corners), radius)
        except MeshMapError as error:
            _LOG.warning("layer %s: %s: it is not cleared", self.layer.name, error)
            return RobotOutline()

    def _clear(self, _request: TriggerRequest) -> TriggerResponse:
        counts = []
        self._change(lambda: counts.append(self.layer.clear()) or counts[0])
        self.mesh_map.catch_up()  # whoever asks plans next
        return TriggerResponse(
            success=True, message="forgotten: %s" % quantity(sum(counts), "marked faces")
        )

    def _run(self) -> None:
        while not self._closed.wait(_PERIOD) and not rospy.is_shutdown():
            self._subscribe()
            self._tell_silence()
            self._change(lambda: self.layer.decay(rospy.get_time()))

    def _silence(self) -> str:
        return str(self.layer.silence(rospy.get_time()))

    def _tell_silence(self) -> None:
        """Logs that a source has been silent for a while, and that all of them speak again."""
        now = time.monotonic()
        silence = self._silence() if self.layer.params["enabled"] else ""
        if not silence:
            self._spoke = now
            if self._complained:
                self._complained = False
                _LOG.info("layer %s: it is current again", self.layer.name)
        elif now - self._spoke > _START:
            self._complained = True
            self._complaints.add("it is not current", silence)


def _points(message: Any, source: ObservationSource) -> Tuple[np.ndarray, np.ndarray]:
    """(N, 3) what was met, and (K, 3) up to where nothing was."""
    if source.data_type == LASER_SCAN:
        return scan_points(message, source.inf_is_valid)
    return cloud_points(message), np.zeros((0, 3))


def _parameter_around(namespace: str, name: str, otherwise: Any) -> Any:
    """A parameter of the nearest namespace around this one that has it, and of the same type as
    what is returned otherwise; a list or text in place of a tuple."""
    parts = namespace.strip("/").split("/")
    for count in range(len(parts) - 1, -1, -1):
        value = rospy.get_param("/" + "/".join(parts[:count] + [name]), None)
        if isinstance(value, int) and isinstance(otherwise, float):
            value = float(value)
        kinds = (list, str) if isinstance(otherwise, tuple) else type(otherwise)
        if isinstance(value, kinds) and value:
            return value
    return otherwise
