"""A simulated robot in a process of its own, and what it publishes."""

import collections
import os
import signal
import subprocess
import tempfile

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from server_process import program
from visualization_msgs.msg import MarkerArray

from mesh_msgs.testing import wait_until


class RobotProcess:
    """A robot in a namespace of its own, and what it publishes."""

    def __init__(self, name, **parameters):
        self.name = name
        parameters = {
            "odom_frame": f"{name}_odom",
            "footprint_frame": f"{name}_footprint",
            "base_frame": f"{name}_base",
            "sensor_frame": f"{name}_laser",
            **parameters,
        }
        for key, value in parameters.items():
            rospy.set_param(f"/{name}/surface_robot/{key}", value)
        self.log = tempfile.NamedTemporaryFile("r", prefix=name, suffix=".log")
        with open(self.log.name, "w") as log:
            self.process = subprocess.Popen(
                [program("mesh_navigation", "surface_robot"), f"__ns:={name}"],
                stdout=log,
                stderr=subprocess.STDOUT,
                env=dict(os.environ),
            )
        self.heard = collections.defaultdict(list)
        types = {
            "odom": Odometry,
            "surface_robot/pose": PoseStamped,
            "surface_robot/markers": MarkerArray,
        }
        self._subscribers = [self._listen(topic, kind) for topic, kind in types.items()]
        self._publishers = {}

    def _listen(self, topic, kind):
        heard = self.heard[topic]
        return rospy.Subscriber(f"/{self.name}/{topic}", kind, heard.append)

    def listen(self, topic, kind):
        self._subscribers.append(self._listen(topic, kind))

    def send(self, topic, message):
        """Publish; the first time, wait for the connection."""
        if topic not in self._publishers:
            name = f"/{self.name}/{topic}"
            self._publishers[topic] = rospy.Publisher(name, type(message), queue_size=10)
            publisher = self._publishers[topic]
            wait_until(publisher.get_num_connections, f"a subscriber of {name}")
        self._publishers[topic].publish(message)

    def wait_for_pose(self, condition=lambda position: True):
        """The next true pose that fulfills the condition."""
        poses = self.heard["surface_robot/pose"]
        begin = len(poses)
        place = []

        def found():
            new = poses[begin:]
            place[:] = [message for message in new if condition(position_of(message.pose))]
            return place

        wait_until(found, f"a pose of {self.name}; it says: {self.output()}")
        return place[0]

    def drive(self, x, condition):
        """Command a speed until the condition holds."""
        command = Twist()
        command.linear.x = x
        poses = self.heard["surface_robot/pose"]

        def done():
            self.send("cmd_vel", command)
            rospy.rostime.wallsleep(0.02)
            return poses and condition(position_of(poses[-1].pose))

        wait_until(done, "a place")

    def output(self):
        self.log.seek(0)
        return self.log.read()

    def stop(self):
        """End it as Ctrl+C does; returns its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


def position_of(pose):
    return np.array([pose.position.x, pose.position.y, pose.position.z])
