"""The cloud that the collision zone looks at."""

from typing import Any, Mapping, Tuple

import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import PointCloud2

from mesh_msgs.point_cloud import PointCloudError, cloud_points
from mesh_msgs.text import one_line
from mesh_msgs.transform import TransformError, rotation_and_translation

from mesh_navigation.velocity_guard.collision_zone import CollisionZone

_UNUSABLE = (PointCloudError, TransformError, tf2_ros.TransformException, rospy.ROSException)
_BUFFER = 1 << 26  # bytes; with less, rospy keeps old clouds in the socket


class CloudWatch:
    """Brings clouds into the robot's frame, by the newest transform, and asks the zone."""

    def __init__(self, settings: Mapping[str, Any]) -> None:
        """``settings``: robot_frame, and the guard's parameters of the zone."""
        self._frame = settings["robot_frame"].lstrip("/")
        self._zone = CollisionZone(
            settings["zone_box"], settings["zone_min_points"], settings["zone_timeout"]
        )
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        topic = settings["zone_topic"]
        rospy.Subscriber(topic, PointCloud2, self._see, queue_size=1, buff_size=_BUFFER)

    def obstruction(self) -> str:
        """As that of the zone, now."""
        return self._zone.obstruction(rospy.get_time())

    def _see(self, message: PointCloud2) -> None:
        try:
            points = cloud_points(message)
            rotation, translation = self._to_robot(message.header.frame_id.lstrip("/"))
        except _UNUSABLE as error:
            self._zone.miss(one_line(error))
            return
        with np.errstate(over="ignore", invalid="ignore"):
            points = points @ rotation.T + translation
        self._zone.see(points, message.header.stamp.to_sec())

    def _to_robot(self, frame: str) -> Tuple[np.ndarray, np.ndarray]:
        if frame == self._frame:
            return np.eye(3), np.zeros(3)
        found = self._buffer.lookup_transform(self._frame, frame, rospy.Time())
        return rotation_and_translation(found)
