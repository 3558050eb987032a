"""Where base and sensors were in the frame of the odometry, by TF."""

import time
from typing import Any, Dict, List

import numpy as np
import rospy
import tf2_ros
from mesh_map.base.errors import MeshMapError
from mesh_msgs.text import one_line
from mesh_msgs.transform import TransformError, rotation_and_translation

from mesh_localization.sensing.placed_scan import PlacedScan, placed_scan
from mesh_localization.sensing.scan_intake import NotYet
from mesh_localization.sensing.sensor_scan import SensorScan

_AHEAD = 1.0  # s
_LATELY = 3.0  # s


class _Listener(tf2_ros.TransformListener):
    """Leaves out transforms that are far ahead of time. Some of before may come after time has
    jumped back and the buffer was cleared: beside them, those of now would be too old for it.

    Attributes:
        others: node -> when it told a parent of the odometry's frame (s of the computer's time).
    """

    def __init__(self, buffer: tf2_ros.Buffer, odom_frame: str) -> None:
        """
        Args:
            buffer: that is filled.
            odom_frame: of the odometry.
        """
        self.others: Dict[str, float] = {}
        self._odom = odom_frame
        super().__init__(buffer)

    def callback(self, data: Any) -> None:
        teller = data._connection_header.get("callerid", "")
        latest = rospy.Time.now() + rospy.Duration.from_sec(_AHEAD)
        data.transforms = [one for one in data.transforms if one.header.stamp <= latest]
        if teller != rospy.get_name():
            if any(one.child_frame_id.lstrip("/") == self._odom for one in data.transforms):
                self.others[teller] = time.monotonic()
        super().callback(data)


class OdometryTransforms:
    """A listener to TF."""

    def __init__(self, odom_frame: str, base_frame: str) -> None:
        """
        Args:
            odom_frame, base_frame: of the odometry, and of the robot.
        """
        self._odom, self._base = odom_frame.lstrip("/"), base_frame.lstrip("/")
        self._buffer = tf2_ros.Buffer(debug=False)
        self._listener = _Listener(self._buffer, self._odom)

    def now(self) -> np.ndarray:
        """(4, 4) of the base in the odometry's frame, the newest.

        Raises:
            NotYet: there is none.
        """
        return self._found(self._odom, self._base, rospy.Time())

    def others(self) -> List[str]:
        """Nodes that told in the last seconds where the odometry's frame is, too."""
        now, told = time.monotonic(), dict(self._listener.others)
        return sorted(name for name, at in told.items() if now - at < _LATELY)

    def between(self, frame: str, other: str, stamp: Any) -> np.ndarray:
        """(4, 4) of the other frame in a frame.

        Raises:
            NotYet: there is no transform.
        """
        return self._found(frame.lstrip("/"), other.lstrip("/"), stamp)

    def place(self, scan: SensorScan) -> PlacedScan:
        """A scan in the frame of the base.

        Raises:
            NotYet: transforms are missing.
            MeshMapError: one of them is none.
        """
        if not scan.frame:
            raise MeshMapError("it has no frame_id")

        def at(frame: str, offset: float) -> np.ndarray:
            stamp = scan.stamp + rospy.Duration.from_sec(offset) if offset else scan.stamp
            return self._found(self._odom, frame, stamp)

        return placed_scan(
            scan, lambda offset: at(scan.frame, offset), lambda offset: at(self._base, offset)
        )

    def _found(self, frame: str, other: str, stamp: Any) -> np.ndarray:
        if frame == other:
            return np.eye(4)
        try:
            found = self._buffer.lookup_transform(frame, other, stamp)
            rotation, translation = rotation_and_translation(found)
        except tf2_ros.TransformException as error:
            text = "no transform from '%s' to '%s': %s"
            reason = one_line(error).rstrip(". ")
            raise NotYet(text % (other, frame, reason)) from error
        except TransformError as error:
            raise MeshMapError(str(error)) from error
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation, translation
        return pose
