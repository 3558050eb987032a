"""The robot over TF, odometry and velocity commands."""

import threading
from typing import Optional, Tuple

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from mesh_navigation.base.messages import twist_message, velocity_of
from mesh_navigation.base.robot import STOP, Robot, RobotLost, RobotState, Trail, Velocity
from mesh_navigation.server.ros.transforms_ros import Transforms

# Odometry that is older (s, of ROS time) says nothing about the velocity of now.
ODOMETRY_AGE = 1.0


class RobotRos(Robot):
    """Poses from TF, velocities from odometry where there is some; commands go to ``cmd_vel``."""

    def __init__(
        self, transforms: Transforms, robot_frame: str, lost_timeout: float, odom_topic: str = ""
    ) -> None:
        """
        Args:
            transforms: to ask for the pose.
            robot_frame: the robot's frame in TF.
            lost_timeout: how long to wait for its pose while it drives (s).
            odom_topic: nav_msgs/Odometry, whose twist is in the robot's frame; empty: none.
        """
        self.trail, self.lost_timeout = Trail(), lost_timeout
        self.frame = ""
        """The map's frame; empty as long as there is no map."""
        self._transforms, self._robot_frame = transforms, robot_frame
        self._lock = threading.Lock()
        self._commanded = STOP
        self._odometry: Optional[Tuple[float, Velocity]] = None
        self._commands = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        if odom_topic:
            rospy.Subscriber(odom_topic, Odometry, self._on_odometry, queue_size=1)

    def state(self) -> RobotState:
        if not self.frame:
            raise RobotLost("the robot's pose is not known: there is no map yet")
        pose, stamp = self._transforms.newest(self.frame, self._robot_frame)
        fault = pose.fault()
        if fault:
            what = f"the robot's pose ('{self._robot_frame}' in '{self.frame}')"
            raise RobotLost(f"{what} is none: {fault}")
        return RobotState(stamp, pose.normalized(), self._velocity(rospy.get_time()))

    def drive(self, velocity: Velocity) -> None:
        # During a shutdown nobody drives any more, however late it is.
        if rospy.core.is_shutdown_requested() or not velocity.is_finite:
            velocity = STOP
        message = twist_message(velocity)
        # Under the lock: commands leave in the order in which they are noted.
        with self._lock:
            self._commanded = velocity
            try:
                self._commands.publish(message)
            except rospy.ROSException:
                # A shutdown closes topics at any moment, and before rospy.is_shutdown() says so.
                if not rospy.core.is_shutdown_requested():
                    raise

    def _velocity(self, now: float) -> Velocity:
        odometry = self._odometry
        if odometry is not None and abs(now - odometry[0]) <= ODOMETRY_AGE:
            return odometry[1]
        return self._commanded

    def _on_odometry(self, message: Odometry) -> None:
        velocity = velocity_of(message.twist.twist)
        if velocity.is_finite:
            self._odometry = rospy.get_time(), velocity
