#!/usr/bin/python3
"""A robot that is driven on localization: the launch file for users, with odometry that slips and
drifts and a lidar with noise. It arrives where it was sent; carried elsewhere it stands, finds out
where it is, and arrives, too.
"""
import itertools
import math
import tempfile
import threading
import unittest
from contextlib import ExitStack
from pathlib import Path

import actionlib
import numpy as np
import rospy
import rostest
import yaml
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from mbf_msgs.msg import MoveBaseAction, MoveBaseGoal, MoveBaseResult
from mesh_msgs.msg import LocalizationState
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_tools_test.demo.processes import process
from mesh_tools_test.driving import shipped
from std_msgs.msg import Time as TimeMessage
from std_srvs.srv import Trigger

SERVER, ROBOT, LOCALIZER = "/move_base_flex", "/surface_robot", "/mesh_localization"
LOST, OK = LocalizationState.LOST, LocalizationState.OK
SIZE, FACES = 24.0, 40_000  # m, of the world
DRIFT = math.radians(0.5)  # rad of the odometry's heading in each meter
# (x, y, z, yaw) m, rad: where it begins, its goals, and where it is put on its way to the second.
START, FIRST = (-8.83, -5.33, 1.18, 1.0), (-5.67, -0.4, 1.35, 0.0)
SECOND, ELSEWHERE = (-7.91, -3.53, 1.29, -2.0), (-0.83, 0.01, 1.59, 2.0)
TOLD_OFF = np.array([0.24, -0.18, 0.0, 0.07])  # m, rad: 0.3 m off, as one clicks
OFF = 0.05  # m that localization may be off at a goal, beside the server's tolerance
AHEAD = 0.7  # s that time may go on beyond the last state; it is told every 0.5 s at least
NOTICED = 2.0  # m that it may drive until it notices that it was kidnapped
BRAKING, STANDING = 1.0, 3.0  # s by its own clock
PATIENCE = 240.0  # s of the computer's time


class Localization(unittest.TestCase):
    """Two drives, and a kidnapping."""

    @classmethod
    def setUpClass(cls):
        cls.stack = ExitStack()
        folder = Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        world, file = outdoor_world(FACES, size=SIZE), folder / "map.h5"
        MapFile.write(str(file), Mesh(vertices=world.vertices, faces=world.faces))
        cls.logs = folder / "logs"
        layers = dict(shipped.configuration("simulation_map"))
        # Simulated time runs as fast as the localization: on a busy machine clouds are late by it.
        layers["obstacles"] = {**layers["obstacles"], "expected_update_rate": 0.0}
        (folder / "layers.yaml").write_text(yaml.safe_dump(layers))
        rospy.set_param(SERVER, {"localization_patience": 0.0})  # as long as it takes
        rospy.set_param(ROBOT, {"scan_rate": 10.0, "scan_noise": 0.015, "rate": 25.0})
        cls.stack.enter_context(process("simulation", launch(folder), cls.logs))
        rospy.init_node("localization")

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    def setUp(self):
        self.states, self.commands, self.track = [], [], []
        self.is_awaited, self.is_held = threading.Event(), threading.Event()  # LOST, and time
        self.commands_before = 0  # that LOST
        self.limit = rospy.Publisher("/clock_limit", TimeMessage, queue_size=10)
        self.told = {
            topic: rospy.Publisher(topic, PoseWithCovarianceStamped, queue_size=1)
            for topic in ("/initialpose", ROBOT + "/initialpose")
        }
        self.subscribers = [
            rospy.Subscriber(LOCALIZER + "/state", LocalizationState, self.hear),
            rospy.Subscriber("/cmd_vel", Twist, self.commands.append, queue_size=10_000),
            rospy.Subscriber(ROBOT + "/pose", PoseStamped, self.follow, queue_size=10_000),
        ]

    def hear(self, message):
        """Time goes on with the states; from LOST on it stands until the test lets it go on."""
        self.states.append(message)
        if message.state == LOST and self.is_awaited.is_set():
            self.is_awaited.clear()
            self.is_held.set()
            self.commands_before = len(self.commands)
        ahead = 0.0 if self.is_held.is_set() else AHEAD
        self.limit.publish(message.header.stamp + rospy.Duration.from_sec(ahead))

    def follow(self, message):
        place, turn = message.pose.position, message.pose.orientation
        yaw = 2.0 * math.atan2(turn.z, turn.w)
        self.track.append((message.header.stamp.to_sec(), place.x, place.y, place.z, yaw))

    def wait_for(self, condition, what):
        """Poll; fail with what the nodes have printed."""
        try:
            wait_until(condition, what, PATIENCE)
        except AssertionError as error:
            log = (self.logs / "simulation.log").read_text()[-4000:]
            self.fail("%s; last state: %s\n%s" % (error, self.states[-1:], log))

    def test_it_arrives_on_localization_and_stands_while_it_is_lost(self):
        self.client = actionlib.SimpleActionClient(SERVER + "/move_base", MoveBaseAction)
        self.wait_for(lambda: self.client.wait_for_server(rospy.Duration(0.01)), "a server")
        self.wait_for(lambda: self.track and self.states, "robot and localization")
        self.is_told_where_it_is()
        self.arrives(FIRST, self.drive(FIRST))
        ended = self.drive(SECOND)
        self.wait_for(lambda: self.left(FIRST) > 1.0, "half of the way")
        self.stands_once_it_is_kidnapped()
        self.assertEqual(ended, [])
        self.looks_for_itself()
        self.arrives(SECOND, ended)

    def left(self, place):
        """m from a place."""
        return np.linalg.norm(np.subtract(self.track[-1][1:4], place[:3]))

    def put(self, pose, topic):
        """Tell a pose (x, y, z, yaw)."""
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        place.x, place.y, place.z = map(float, pose[:3])
        turn.z, turn.w = math.sin(pose[3] / 2), math.cos(pose[3] / 2)
        self.wait_for(self.told[topic].get_num_connections, "who listens on " + topic)
        self.told[topic].publish(message)

    def is_told_where_it_is(self):
        self.wait_for(lambda: self.states[-1].state == LOST, "a robot that is lost")
        self.put(np.array(self.track[-1][1:]) + TOLD_OFF, "/initialpose")
        self.wait_for(lambda: self.states[-1].state == OK, "a robot that knows where it is")

    def looks_for_itself(self):
        """On the whole map, without a pose."""
        answer = rospy.ServiceProxy(LOCALIZER + "/relocalize", Trigger)()
        self.assertTrue(answer.success, answer.message)
        self.wait_for(lambda: self.states[-1].state == OK, "a robot that has found itself")

    def drive(self, goal):
        """Send a goal; returns a list that gets its end."""
        ended = []
        message = MoveBaseGoal()
        message.target_pose.header.frame_id = "map"
        place, turn = message.target_pose.pose.position, message.target_pose.pose.orientation
        place.x, place.y, place.z = goal[:3]
        turn.z, turn.w = math.sin(goal[3] / 2), math.cos(goal[3] / 2)
        self.client.send_goal(message, done_cb=lambda *end: ended.append(end))
        return ended

    def arrives(self, goal, ended):
        self.wait_for(lambda: ended, "the end of a drive")
        state, result = ended[0]
        self.assertEqual(state, actionlib.GoalStatus.SUCCEEDED, result.message)
        self.assertEqual(result.outcome, MoveBaseResult.SUCCESS)
        count = len(self.track)
        self.wait_for(lambda: len(self.track) > count + 5, "the robot's pose at the end")
        self.assertLess(self.left(goal), shipped.server()["dist_tolerance"] + OFF)

    def stands_once_it_is_kidnapped(self):
        """It drives until it notices. Then no command moves it any more from the first zero on,
        which comes while time stands.
        """
        states = len(self.states)
        self.is_awaited.set()
        self.put(ELSEWHERE, ROBOT + "/initialpose")
        self.wait_for(self.is_held.is_set, "a robot that notices it")
        self.assertLess(self.left(ELSEWHERE), NOTICED)
        self.wait_for(self.zeros, "zero velocities")
        self.is_held.clear()
        begin = self.track[-1][0] + BRAKING
        self.wait_for(lambda: self.track[-1][0] > begin + STANDING, "some time")
        self.assertTrue(all(map(is_zero, self.zeros())))
        stood = np.array([pose for pose in self.track if pose[0] > begin])
        self.assertLess(np.abs(stood - stood[0])[:, 1:].max(), 1e-6)
        states = [message.state for message in self.states[states:]]
        self.assertEqual(set(states[states.index(LOST) :]), {LOST})

    def zeros(self):
        """The commands from the first zero on after the robot was lost."""
        commands = self.commands[self.commands_before :]
        return list(itertools.dropwhile(lambda velocity: not is_zero(velocity), commands))


def launch(folder):
    """As a user starts it."""
    return [
        *("roslaunch", "mesh_navigation", "simulation.launch"),
        *("map_file:=%s/map.h5" % folder, "map_config:=%s/layers.yaml" % folder),
        *("localization:=true", "real_time_factor:=0", "slip:=0.01"),
        *("odometry_yaw_drift:=%f" % DRIFT, "initial_pose:=%s" % list(START)),
    ]


def is_zero(velocity):
    """Whether a Twist moves nothing."""
    parts = velocity.linear, velocity.angular
    return not any(getattr(part, axis) for part in parts for axis in "xyz")


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "localization", Localization)
