#!/usr/bin/python3
"""The action recovery, on its bare topics, with behaviors that misbehave and the real ones."""

import os
import random
import time
import unittest

import rospy
import rostest
import tf2_ros
from actionlib_msgs.msg import GoalStatus
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import TransformStamped
from navigation_process import ActionTopics, NodeProcess, Velocities
from server_process import TESTS, write_map
from std_srvs.srv import Trigger

from mesh_msgs import zoo
from mesh_msgs.testing import wait_until

ODD = TESTS / "odd_recoveries"
NAMES = "Outcome Slow Deaf Throwing Lost Lame".split()
BEHAVIORS = [{"name": name.lower(), "type": f"odd/{name}Recovery"} for name in NAMES]
BEHAVIORS += [
    {"name": name.lower(), "type": f"mesh_recovery/{name}"}
    for name in ("Wait", "BackUp", "ClearLayers", "Unheard")
]
SUCCEEDED, ABORTED, REJECTED = GoalStatus.SUCCEEDED, GoalStatus.ABORTED, GoalStatus.REJECTED
CANCELED = (GoalStatus.PREEMPTED, GoalStatus.RECALLED)
NODE = "recovering"
PATIENCE = 60.0  # seconds


def robot_at(x, y):
    """The robot stands there from now on; it is always up to date."""
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = "map", "base_link"
    message.transform.translation.x, message.transform.translation.y = x, y
    message.transform.rotation.w = 1.0
    return message


def parameters(**others):
    found = {
        "recovery_behaviors": BEHAVIORS,
        "mesh_map": {
            "mesh_file": write_map(zoo.grid()),
            "layers": [{"name": "obstacles", "type": "mesh_layers/ObstacleLayer"}],
            "obstacles": {"topic": "/cloud", "expected_update_rate": 0},
        },
        "recovery_patience": PATIENCE,
        "wait": {"seconds": 0.1},
    }
    return {**found, **others}


class RecoveryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node = NodeProcess(NODE, "mbf_mesh_nav", **parameters())
        cls.broadcaster = tf2_ros.StaticTransformBroadcaster()
        cls.broadcaster.sendTransform([robot_at(5.0, 5.0)])
        cls.velocities = Velocities()
        cls.topics = ActionTopics(NODE, "recovery")
        cls.keys = iter(range(10**6))
        wait_until(lambda: cls.ask("wait")[1].outcome == 0, "the map")
        cls.values = Client(f"/{NODE}/outcome", timeout=60)

    @classmethod
    def tearDownClass(cls):
        try:
            status, _ = cls.node.end()
        finally:
            cls.node.kill()
        assert status == 0, cls.node.output()

    @classmethod
    def send(cls, behavior, **fields):
        return cls.topics.send(f"goal {next(cls.keys)}", behavior=behavior, **fields)

    @classmethod
    def ask(cls, behavior, **fields):
        return cls.topics.answer(cls.send(behavior, **fields))

    def check(self, given, state, outcome, *words, used=None):
        found, result = given
        self.assertEqual((found, result.outcome), (state, outcome), result.message)
        self.assertTrue(result.message)
        for word in words:
            self.assertIn(word, result.message)
        if used is not None:
            self.assertEqual(result.used_plugin, used)

    def be_patient(self, seconds):
        """Within a test; others have far more than behaviors take."""
        server = Client(f"/{NODE}", timeout=60)
        server.update_configuration({"recovery_patience": seconds})
        self.addCleanup(server.close)
        self.addCleanup(server.update_configuration, {"recovery_patience": PATIENCE})

    def stands(self, most_moves=None):
        """Once quiet: the first zero may be of the drive before, and the last move be under way.

        ``most_moves``: that the behavior was given to drive, since they were forgotten.
        """
        wait_until(self.is_quiet, "zero velocity")
        if most_moves is not None:
            self.assertLessEqual(self.velocities.moves, most_moves)

    def is_quiet(self):
        moves = self.velocities.moves
        time.sleep(0.1)
        return self.velocities.stopped and self.velocities.moves == moves

    def test_a_failure_is_a_failure(self):
        for outcome in (150, 151, 152, 153, 154, 156, 158, 171, 199, 7, 0):
            self.velocities.forget()
            self.values.update_configuration({"outcome": outcome})
            given = self.ask("outcome")
            state = SUCCEEDED if outcome < 10 else ABORTED
            state = GoalStatus.PREEMPTED if outcome == 151 else state
            words = f"outcome {outcome}, as asked for"
            self.check(given, state, outcome, words, used="outcome")
            self.stands(most_moves=1)
        self.values.update_configuration({"outcome": 1000})
        self.check(self.ask(""), ABORTED, 156, "its outcome is 1000", used="outcome")

    def test_rejected(self):
        given = self.ask("dance")
        words = "there is no recovery behavior 'dance'", "known: outcome, slow", "backup"
        self.check(given, REJECTED, 155, *words, used="dance")
        self.check(self.ask("unheard"), REJECTED, 155)
        self.assertIn("recovery behavior 'unheard' is skipped", self.node.output())
        self.assertNotIn("cannot be reconfigured", self.node.output())

    def test_behaviors_that_fail(self):
        words = "throwing: ", "ZeroDivisionError: by zero"
        for behavior, outcome, *words in (
            ("throwing", 156, *words),
            ("lost", 153, "lost: nowhere to be seen"),
            ("lame", 154, "'lame' could not be initialized", "no legs"),
        ):
            self.velocities.forget()
            self.check(self.ask(behavior), ABORTED, outcome, *words, used=behavior)
            if behavior != "lame":
                self.stands(most_moves=1)

    def test_patience(self):
        self.be_patient(0.4)
        self.check(self.ask("slow"), ABORTED, 152, "patience of 0.40 s", used="slow")
        self.stands()
        self.velocities.forget()
        given = self.ask("deaf")
        self.check(given, ABORTED, 152, "patience of 0.40 s", "did not stop within 0.5 s")
        self.stands(most_moves=90)  # Of the 100 that it sends in three seconds.

    def test_the_real_ones(self):
        self.check(self.ask("wait"), SUCCEEDED, 0, "wait: waited for 0.1 s", used="wait")
        given = self.ask("clearlayers")
        self.check(given, SUCCEEDED, 0, "clearlayers: cleared: 0 in layer obstacles")

    def test_a_robot_that_does_not_get_on(self):
        """It stands still in TF; the patience is shorter than that of the behavior."""
        self.be_patient(0.4)
        self.velocities.forget()
        self.check(self.ask("backup"), ABORTED, 152, used="backup")
        self.stands()

    def test_a_robot_at_the_border(self):
        self.broadcaster.sendTransform([robot_at(0.1, 5.0)])
        self.addCleanup(self.broadcaster.sendTransform, [robot_at(5.0, 5.0)])
        wait_until(lambda: self.ask("backup")[1].outcome == 158, "TF")
        words = "behind the robot (clearance 0.20 m) the surface ends at (0.00, 5.00"
        self.check(self.ask("backup"), ABORTED, 158, words, "backed up by 0.00 m")

    def test_a_new_goal_takes_the_slot(self):
        old, other = self.send("slow", concurrency_slot=1), self.send("wait", concurrency_slot=2)
        new = self.send("wait", concurrency_slot=1)
        self.check(self.topics.answer(new), SUCCEEDED, 0)
        self.check(self.topics.answer(other), SUCCEEDED, 0)
        self.check(self.topics.answer(old), GoalStatus.PREEMPTED, 151, "a newer goal took slot 1")

    def test_a_hundred_cancels_at_random_times(self):
        pauses = random.Random(0)
        for _ in range(100):
            key = self.send("slow")
            time.sleep(pauses.choice([0.0, pauses.uniform(0, 0.03)]))
            self.topics.cancel(key)
            state, result = self.topics.answer(key)
            self.assertIn(state, CANCELED)
            self.assertEqual(result.outcome, 151)
            self.assertTrue(result.message)
        self.stands()
        self.assertEqual({len(answers) for answers in self.topics.results.values()}, {1})

    def test_a_map_that_is_loaded_anew(self):
        self.be_patient(0.0)
        self.velocities.forget()
        key = self.send("slow")
        wait_until(lambda: self.velocities.moving, "the start")
        self.assertTrue(rospy.ServiceProxy(f"/{NODE}/reload_map", Trigger)().success)
        self.check(self.topics.answer(key), ABORTED, 154, "the map is loaded anew", used="slow")
        self.stands()


class OtherServersTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Both servers at once; each test ends its own."""
        cls.nodes = {
            name: NodeProcess(name, "mbf_mesh_nav", **parameters(**others))
            for name, others in (
                ("without_map", {"mesh_map": {"mesh_file": "/nowhere/garden.h5"}}),
                ("stopping_recovery", {"recovery_patience": 0.0}),
            )
        }

    @classmethod
    def tearDownClass(cls):
        for node in cls.nodes.values():
            node.kill()

    def started(self, name):
        return self.nodes[name], ActionTopics(name, "recovery", self.nodes[name])

    def test_without_a_map(self):
        node, topics = self.started("without_map")
        state, result = topics.answer(topics.send("goal", behavior="wait"))
        self.assertEqual((state, result.outcome, result.used_plugin), (ABORTED, 154, "wait"))
        self.assertIn("there is no map: ", result.message)
        self.assertEqual(node.end()[0], 0)

    def test_a_server_that_stops(self):
        velocities = Velocities()
        self.addCleanup(velocities.close)
        node, topics = self.started("stopping_recovery")
        key = topics.send("goal", behavior="slow")
        wait_until(lambda: velocities.moving, "the start")
        status, _ = node.end()
        state, result = topics.answer(key)
        self.assertEqual((state, result.outcome, result.used_plugin), (ABORTED, 157, "slow"))
        self.assertEqual(result.message, "the server is shut down")
        self.assertEqual(status, 0)
        wait_until(lambda: velocities.stopped, "zero velocity")


class Suite(unittest.TestSuite):
    def __init__(self):
        load = unittest.defaultTestLoader.loadTestsFromTestCase
        super().__init__([load(RecoveryTest), load(OtherServersTest)])


if __name__ == "__main__":
    os.environ["ROS_PACKAGE_PATH"] = f"{ODD}:{os.environ['ROS_PACKAGE_PATH']}"
    os.environ["PYTHONPATH"] = f"{ODD / 'src'}:{os.environ['PYTHONPATH']}"
    rospy.init_node("recovery_test")
    rostest.rosrun("mesh_navigation", "recovery", "recovery_rostest.Suite")
