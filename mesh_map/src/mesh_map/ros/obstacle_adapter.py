"""Point clouds from ROS for the layer of obstacles."""

import logging
import threading
from typing import Any, Callable, Optional, Tuple

import numpy as np
import rospy
import tf2_ros
from mesh_msgs.text import one_line
from mesh_msgs.transform import TransformError, rotation_and_translation
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from mesh_map.base.errors import MeshMapError, error_line
from mesh_map.geometry.topology import quantity
from mesh_map.io.point_cloud import cloud_points
from mesh_map.ros.complaints import ThrottledWarnings
from mesh_map.ros.ros_adapter import RosAdapter
from mesh_map.ros.transforms import SharedTransforms

_LOG = logging.getLogger("mesh_map")
_PERIOD = 0.2  # seconds between two looks at what has become too old
_CLOSING_TIME = 2.0  # seconds
# With the last, rospy ends a wait for a transform when a bag begins again.
_UNUSABLE = (MeshMapError, TransformError, tf2_ros.TransformException, rospy.ROSException)
_BUFFER = 1 << 26  # bytes; with less, rospy keeps old clouds in the socket


class ObstacleAdapter(RosAdapter):
    """Hands the clouds of the layer's topic to it, and tells it when time passes.

    Clouds are brought into the frame of the map by the transform of their stamp. The sensor is at
    the origin of their frame, or of the parameter sensor_frame. The newest cloud counts where they
    come faster than they can be used. Those that cannot be used are counted in one warning every
    ten seconds. Marks age by the ROS time at which clouds arrive, so bags may be played with and
    without simulated time. A topic that is changed is subscribed to at once.

    Service: <namespace>/clear (std_srvs/Trigger) forgets all obstacles.
    """

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._lock = threading.Lock()  # held while the layer or the map changes
        self._due = False  # the layer has changed, and the map does not know it yet
        self._closed = threading.Event()
        self._complaints = ThrottledWarnings(self.layer.name)
        self._transforms = SharedTransforms.acquired()
        self._subscriber: Optional[rospy.Subscriber] = None
        self._topic: Optional[str] = None
        self._robot_frame = _parameter_around(self.namespace, "robot_frame")
        self._service = rospy.Service(self.namespace + "/clear", Trigger, self._clear)
        self._subscribe()
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
        if self._subscriber is not None:
            self._subscriber.unregister()
        self._transforms.release()

    def _subscribe(self) -> None:
        topic = self.layer.params["topic"]
        if topic == self._topic:
            return
        if self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None
        self._topic = topic
        reason = "" if topic else "the parameter topic is not set: no obstacles"
        if topic:
            try:
                self._subscriber = rospy.Subscriber(
                    topic, PointCloud2, self._on_cloud, queue_size=1, buff_size=_BUFFER
                )
            except (ValueError, rospy.ROSException) as error:
                reason = "no topic %r: %s" % (topic, one_line(error))
        if reason:
            _LOG.error("layer %s: %s", self.layer.name, reason)
        self.mesh_map.set_without_data(self.layer.name, reason)

    def _on_cloud(self, message: PointCloud2) -> None:
        """Called by rospy, in one thread for each publisher."""
        try:
            points = cloud_points(message)
            stamp = message.header.stamp
            rotation, translation = self._to_map(message.header.frame_id, stamp)
            origin = self._sensor(message.header.frame_id, stamp)
            down = self._down(stamp)
        except _UNUSABLE as error:
            if not rospy.is_shutdown():
                topic = rospy.resolve_name(self._topic)
                self._complaints.add("clouds from %s cannot be used" % topic, error)
            return
        with np.errstate(over="ignore", invalid="ignore"):
            points = points @ rotation.T + translation
        now = rospy.get_time()
        self._change(lambda: self.layer.insert_cloud(self.mesh_map, points, origin, now, down=down))
        rospy.logdebug("layer %s: %s", self.layer.name, self.layer.last_cloud)

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

    def _to_map(self, frame: str, stamp: rospy.Time) -> Tuple[np.ndarray, np.ndarray]:
        """Rotation (3, 3) and translation (3,) from a frame into that of the map."""
        frame, target = frame.lstrip("/"), self.mesh_map.frame_id.lstrip("/")
        if frame == target:
            return np.eye(3), np.zeros(3)
        if not frame:
            raise MeshMapError("a cloud has no frame_id")
        wait = rospy.Duration.from_sec(self.layer.params["tf_tolerance"])
        found = self._transforms.buffer.lookup_transform(target, frame, stamp, wait)
        return rotation_and_translation(found)

    def _sensor(self, cloud_frame: str, stamp: rospy.Time) -> np.ndarray:
        """Where the sensor is, in the frame of the map."""
        frame = self.layer.params["sensor_frame"]
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

    def _clear(self, _request: TriggerRequest) -> TriggerResponse:
        counts = []
        self._change(lambda: counts.append(self.layer.clear()) or counts[0])
        return TriggerResponse(
            success=True, message="forgotten: %s" % quantity(sum(counts), "marked faces")
        )

    def _run(self) -> None:
        while not self._closed.wait(_PERIOD) and not rospy.is_shutdown():
            self._subscribe()
            self._change(lambda: self.layer.decay(rospy.get_time()))


def _parameter_around(namespace: str, name: str) -> str:
    """A parameter of the nearest namespace around this one that has it; "" if none has."""
    parts = namespace.strip("/").split("/")
    for count in range(len(parts) - 1, -1, -1):
        value = rospy.get_param("/" + "/".join(parts[:count] + [name]), None)
        if isinstance(value, str) and value:
            return value
    return ""
