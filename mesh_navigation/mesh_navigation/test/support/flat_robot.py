"""A robot on a plane, for tests: obeys cmd_vel, tells where it is through TF."""

import math
import threading
import time

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped, Twist

PERIOD = 0.01


class FlatRobot:
    """Moves in a thread of its own, by the system's clock."""

    def __init__(self, x, y):
        self.x, self.y, self.yaw = x, y, 0.0
        self.lost = False
        self.commands = []
        self._broadcaster = tf2_ros.TransformBroadcaster()
        self._subscriber = rospy.Subscriber("/cmd_vel", Twist, self.commands.append)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def stands(self):
        """Whether the last command was zero velocity."""
        last = self.commands[-1] if self.commands else Twist()
        return (last.linear.x, last.linear.y, last.angular.z) == (0.0, 0.0, 0.0)

    def stop(self):
        self._end.set()
        self._thread.join()

    def _run(self):
        last = time.monotonic()
        while not self._end.wait(PERIOD):
            now = time.monotonic()
            if self.commands:
                self._move(self.commands[-1], now - last)
            last = now
            if not self.lost and not rospy.is_shutdown():
                self._broadcaster.sendTransform(self._transform())

    def _move(self, command, seconds):
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        self.x += seconds * (cos * command.linear.x - sin * command.linear.y)
        self.y += seconds * (sin * command.linear.x + cos * command.linear.y)
        self.yaw += seconds * command.angular.z

    def _transform(self):
        message = TransformStamped()
        message.header.stamp = rospy.Time.now()
        message.header.frame_id, message.child_frame_id = "map", "base_link"
        message.transform.translation.x, message.transform.translation.y = self.x, self.y
        rotation = message.transform.rotation
        rotation.z, rotation.w = math.sin(self.yaw / 2), math.cos(self.yaw / 2)
        return message
