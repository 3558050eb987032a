"""ROS messages from and to arrays. No rospy: messages are plain data."""

from typing import Any, Optional

import genpy
import numpy as np
from geometry_msgs.msg import Point
from geometry_msgs.msg import Pose as PoseMessage
from geometry_msgs.msg import PoseStamped, Quaternion
from nav_msgs.msg import Path
from std_msgs.msg import Header

from mesh_navigation.base.pose import Pose


def pose_from_message(message: PoseStamped) -> Pose:
    """The pose as arrays, in the frame of the message, not checked."""
    p, q = message.pose.position, message.pose.orientation
    return Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]))


def pose_message(
    pose: np.ndarray, frame_id: str, stamp: Optional[genpy.Time] = None
) -> PoseStamped:
    """A message from one (7,) row: position and quaternion x, y, z, w."""
    message = PoseStamped()
    message.header.frame_id = frame_id
    message.header.stamp = stamp or genpy.Time()
    x, y, z, qx, qy, qz, qw = (float(value) for value in pose)
    message.pose.position = Point(x, y, z)
    message.pose.orientation = Quaternion(qx, qy, qz, qw)
    return message


def float32(number: float) -> float:
    """As a field of that type takes it: what is too large is infinite there."""
    with np.errstate(over="ignore"):
        return float(np.float32(number))


def path_message(poses: np.ndarray, frame_id: str, stamp: Any) -> Path:
    """A path from (N,7) poses; every pose carries frame and stamp too."""
    # Messages that are made without arguments fill themselves with others first: of a path of a
    # thousand poses that is felt.
    rows = np.asarray(poses, dtype=np.float64).tolist()
    stamped = [
        PoseStamped(
            Header(0, stamp, frame_id),
            PoseMessage(Point(*row[:3]), Quaternion(*row[3:])),
        )
        for row in rows
    ]
    return Path(Header(0, stamp, frame_id), stamped)


def poses_from_path(message: Path) -> np.ndarray:
    """(N,7) float64: the poses of a path as they are, in the frame of the message, not checked."""
    poses = [stamped.pose for stamped in message.poses]
    rows = [
        (p.position.x, p.position.y, p.position.z)
        + (p.orientation.x, p.orientation.y, p.orientation.z, p.orientation.w)
        for p in poses
    ]
    return np.array(rows, dtype=np.float64).reshape(-1, 7)
