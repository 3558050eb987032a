"""ROS messages from and to arrays. No rospy: messages are plain data."""

from typing import Any, Optional

import genpy
import numpy as np
from geometry_msgs.msg import Point
from geometry_msgs.msg import Pose as PoseMessage
from geometry_msgs.msg import PoseStamped, Quaternion, Twist
from nav_msgs.msg import Path
from std_msgs.msg import Header

from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import Velocity


def pose_from_message(message: PoseMessage) -> Pose:
    """The pose as arrays, in the frame of the message, not checked."""
    p, q = message.position, message.orientation
    return Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]))


def bare_pose(pose: Pose) -> PoseMessage:
    """The message of a pose."""
    return PoseMessage(Point(*map(float, pose.position)), Quaternion(*map(float, pose.orientation)))


def pose_message(pose: Pose, frame_id: str, stamp: Optional[genpy.Time] = None) -> PoseStamped:
    """The message of a pose, with its frame."""
    return PoseStamped(Header(0, stamp or genpy.Time(), frame_id), bare_pose(pose))


def velocity_of(message: Twist) -> Velocity:
    """The velocity of a command, or of odometry."""
    return Velocity(message.linear.x, message.linear.y, message.angular.z)


def twist_message(velocity: Velocity) -> Twist:
    """The message of a velocity."""
    message = Twist()
    message.linear.x, message.linear.y, message.angular.z = map(float, velocity)
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
