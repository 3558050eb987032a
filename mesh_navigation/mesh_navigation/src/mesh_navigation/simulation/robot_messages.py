"""What a simulated robot tells, as ROS messages. No rospy: messages are plain data."""

from typing import Any, Sequence

import numpy as np
from geometry_msgs.msg import Point, Pose as PoseMessage, Quaternion, TransformStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2, PointField

from mesh_navigation.base.pose import Pose, multiply, rotate
from mesh_navigation.base.robot import Velocity


def inverted(pose: Pose) -> Pose:
    """The parent's pose in the child, of a child's pose (unit quaternion) in the parent."""
    back = pose.orientation * np.array([-1.0, -1.0, -1.0, 1.0])
    return Pose(-rotate(back, pose.position), back)


def combined(first: Pose, second: Pose) -> Pose:
    """The pose in the grandparent of a ``second`` that is given in the frame of the ``first``."""
    return Pose(
        first.position + rotate(first.orientation, second.position),
        multiply(first.orientation, second.orientation),
    )


def odometry_origin(truth: Pose, odometry: Pose) -> Pose:
    """The pose of the odometry's frame in the map, so that ``odometry`` in it is the ``truth``."""
    return combined(truth, inverted(odometry))


def velocity_of(message: Twist) -> Velocity:
    """The velocity of a command."""
    return Velocity(message.linear.x, message.linear.y, message.angular.z)


def pose_of(message: PoseMessage) -> Pose:
    """The pose, not checked."""
    p, q = message.position, message.orientation
    return Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]))


def bare_pose(pose: Pose) -> PoseMessage:
    """The message of a pose."""
    return PoseMessage(Point(*map(float, pose.position)), Quaternion(*map(float, pose.orientation)))


def transform(parent: str, child: str, pose: Pose, stamp: Any) -> TransformStamped:
    """The child's pose in the parent, for TF."""
    message = TransformStamped()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    there = bare_pose(pose)
    translation = message.transform.translation
    translation.x, translation.y, translation.z = (
        there.position.x,
        there.position.y,
        there.position.z,
    )
    message.transform.rotation = there.orientation
    return message


def odometry(parent: str, child: str, pose: Pose, velocity: Velocity, stamp: Any) -> Odometry:
    """Pose in the parent, velocity in the child."""
    message = Odometry()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    message.pose.pose = bare_pose(pose)
    twist = message.twist.twist
    twist.linear.x, twist.linear.y, twist.angular.z = map(float, velocity)
    return message


def cloud(points: np.ndarray, frame_id: str, stamp: Any) -> PointCloud2:
    """(N,3) float32 points of a frame."""
    message = PointCloud2()
    message.header.frame_id, message.header.stamp = frame_id, stamp
    message.height, message.width = 1, len(points)
    message.fields = [
        PointField(name, 4 * column, PointField.FLOAT32, 1) for column, name in enumerate("xyz")
    ]
    message.point_step, message.row_step = 12, 12 * len(points)
    message.is_dense = True
    message.data = np.ascontiguousarray(points, "<f4").tobytes()
    return message


def above(height: float) -> Pose:
    """The pose that is so much (m) above another one."""
    return Pose.at((0.0, 0.0, height))


def numbers_in(given: Any) -> Sequence[Any]:
    """A list as users write it on a command line, too: "1 2 0.5" or "1, 2, 0.5" or 1."""
    if isinstance(given, str):
        return given.replace(",", " ").strip("[] ").split()
    return given if isinstance(given, (list, tuple)) else [given]
