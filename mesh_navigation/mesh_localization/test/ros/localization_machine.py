"""A simulated robot and the node that localizes it, each in a process of its own."""

import collections
import math
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import roslib.packages
import rospy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from mesh_map.io.map_messages import geometry_message
from mesh_map.map.mesh_map import MeshMap
from mesh_map.registration.rigid import inverse, numbers_of
from mesh_msgs.arrays import MeshGeometryStamped
from mesh_msgs.msg import LocalizationState
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from std_msgs.msg import Time as TimeMessage
from tf2_msgs.msg import TFMessage

from mesh_localization.node.messages import pose_matrix

MAP_TOPIC = "/map/mesh"
AHEAD = 0.7  # s that time may go on beyond the last state; it is told every 0.5 s at least


def write_map(mesh):
    """A map file of the mesh; returns its path."""
    path = Path(tempfile.mkdtemp(prefix="mesh_localization_")) / "map.h5"
    MapFile.write(str(path), Mesh(vertices=mesh.vertices, faces=mesh.faces))
    return str(path)


class Node:
    """A node of a package with parameters; its output goes to a file."""

    def __init__(self, package, name, *remappings, **parameters):
        for key, value in parameters.items():
            rospy.set_param("/%s/%s" % (name, key), value)
        self._log = tempfile.NamedTemporaryFile("r", prefix=name, suffix=".log")
        with open(self._log.name, "w") as log:
            program = roslib.packages.find_node(package, name)[0]
            self.process = subprocess.Popen(
                [program, *remappings], stdout=log, stderr=subprocess.STDOUT, env=dict(os.environ)
            )

    def output(self):
        self._log.seek(0)
        return self._log.read()

    def stop(self):
        """End it politely; returns its exit code."""
        if self.process.poll() is None:
            self.process.terminate()
        return self.process.wait(30)


class Machine:
    """The robot, the node, and what they tell. Simulated time waits for the node."""

    def __init__(self, mesh, start):
        self.map_file = write_map(mesh)
        self.mesh = mesh
        self.states, self.poses, self.corrections = [], [], []
        self.truth = collections.OrderedDict()  # stamp -> (4, 4)
        self._limit = rospy.Publisher("/clock_limit", TimeMessage, queue_size=10)
        self._map = rospy.Publisher(MAP_TOPIC, MeshGeometryStamped, queue_size=1, latch=True)
        self._velocities = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
        self._starts = {
            topic: rospy.Publisher(topic, PoseWithCovarianceStamped, queue_size=1)
            for topic in ("/initialpose", "/kidnapper")
        }
        for topic, kind, take in (
            ("/mesh_localization/state", LocalizationState, self._on_state),
            ("/mesh_localization/pose", PoseWithCovarianceStamped, self.poses.append),
            ("/surface_robot/pose", PoseStamped, self._on_truth),
            ("/tf", TFMessage, self._on_transforms),
        ):
            rospy.Subscriber(topic, kind, take)
        self.robot = Node(
            "mesh_navigation",
            "surface_robot",
            "initialpose:=/kidnapper",
            mesh_file=self.map_file,
            publish_clock=True,
            localization=False,
            initial_pose=[float(number) for number in start],
            odometry_noise=0.01,
            slip=0.01,
            scan_noise=0.015,
            scan_rate=10.0,
        )
        self.node = Node("mesh_localization", "mesh_localization", mesh_topic=MAP_TOPIC)

    def stop(self):
        return [one.stop() for one in (self.node, self.robot)]

    def _on_state(self, message):
        self.states.append(message)
        self._limit.publish(message.header.stamp + rospy.Duration.from_sec(AHEAD))

    def _on_truth(self, message):
        self.truth[message.header.stamp.to_nsec()] = pose_matrix(message.pose)

    def _on_transforms(self, message):
        for one in message.transforms:
            if one.header.frame_id == "map":
                self.corrections.append(one)

    def publish_map(self, lifted=0.0):
        """The map, or another one in which one vertex is higher."""
        vertices = np.array(self.mesh.vertices)
        vertices[0, 2] += lifted
        self._map.publish(geometry_message(MeshMap(vertices, self.mesh.faces)))

    def place(self):
        """(4, 4), where the robot is."""
        wait_until(lambda: self.truth, "the robot; it says: %s" % self.robot.output())
        return self.truth[next(reversed(self.truth))]

    def say_pose(self, pose, topic="/initialpose"):
        """Tell x, y and heading of a pose, at the height 0 as RViz does."""
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        place.x, place.y = pose[:2, 3]
        angle = math.atan2(pose[1, 0], pose[0, 0])
        turn.z, turn.w = math.sin(angle / 2), math.cos(angle / 2)
        wait_until(self._starts[topic].get_num_connections, "who listens on " + topic)
        self._starts[topic].publish(message)

    def wait_for_state(self, state, words="", since=0):
        """The first message with this state, and these words in its reason."""
        found = []

        def told():
            states = self.states[since:]
            found[:] = [one for one in states if one.state == state and words in one.reason]
            return found

        try:
            wait_until(told, "the state", 30.0)
        except AssertionError:
            told = self.states[-1] if self.states else "nothing"
            text = "no state %d (%s), but %s; the node says: %s"
            raise AssertionError(text % (state, words, told, self.node.output())) from None
        return found[0]

    def drive(self, seconds, speed, turn):
        """So long by the robot's time."""
        end = rospy.get_time() + seconds
        command = Twist()
        command.linear.x, command.angular.z = speed, turn

        def done():
            self._velocities.publish(command)
            return rospy.get_time() >= end

        wait_until(done, "the end of a drive")
        self._velocities.publish(Twist())

    def errors(self, since):
        """(N,) m and (N,) rad that the poses told since then were off the truth."""
        off = []
        for message in self.poses[since:]:
            truth = self.truth.get(message.header.stamp.to_nsec())
            if truth is not None:
                numbers = numbers_of(inverse(truth) @ pose_matrix(message.pose.pose))
                off.append([np.linalg.norm(numbers[:3]), np.linalg.norm(numbers[3:])])
        return np.array(off).reshape(-1, 2).T
