"""What a simulated robot tells, as ROS messages. No rospy: messages are plain data."""

from typing import Any, Sequence

import numpy as np
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from mesh_navigation.base.messages import bare_pose, twist_message
from mesh_navigation.base.pose import Pose, rotate, transformed
from mesh_navigation.base.robot import Velocity


def inverted(pose: Pose) -> Pose:
    """The parent's pose in the child, of a child's pose (unit quaternion) in the parent."""
    back = pose.orientation * np.array([-1.0, -1.0, -1.0, 1.0])
    return Pose(-rotate(back, pose.position), back)


def odometry_origin(truth: Pose, odometry: Pose) -> Pose:
    """The pose of the odometry's frame in the map, so that ``odometry`` in it is the ``truth``."""
    return transformed(inverted(odometry), truth)


def transform(parent: str, child: str, pose: Pose, stamp: Any) -> TransformStamped:
    """The child's pose in the parent, for TF."""
    turned = Transform(Vector3(*map(float, pose.position)), bare_pose(pose).orientation)
    return TransformStamped(Header(0, stamp, parent), child, turned)


def odometry(parent: str, child: str, pose: Pose, velocity: Velocity, stamp: Any) -> Odometry:
    """Pose in the parent, velocity in the child."""
    message = Odometry(header=Header(0, stamp, parent), child_frame_id=child)
    message.pose.pose = bare_pose(pose)
    message.twist.twist = twist_message(velocity)
    return message


def above(height: float) -> Pose:
    """The pose that is so much (m) above another one."""
    return Pose.at((0.0, 0.0, height))


def numbers_in(given: Any) -> Sequence[Any]:
    """A list as users write it on a command line, too: "1 2 0.5" or "1, 2, 0.5" or 1."""
    if isinstance(given, str):
        return given.replace(",", " ").strip("[] ").split()
    return given if isinstance(given, (list, tuple)) else [given]
