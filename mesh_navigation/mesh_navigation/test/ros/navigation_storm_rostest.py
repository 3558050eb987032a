#!/usr/bin/python3
"""The whole server under storms of goals, cancels, reloads and signals: one answer to each goal."""

import itertools
import math
import random
import signal
import time
import unittest
from collections import Counter

import rospy
import rostest
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from mbf_msgs import msg
from nav_msgs.msg import Path
from navigation_process import ACTIONS, ActionTopics, NodeProcess, Velocities, upright
from server_process import write_map
from std_srvs.srv import Trigger

from mesh_msgs import zoo
from mesh_msgs.testing import wait_until

MAP = write_map(zoo.grid(cells=20))
LAYERS = [{"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}]
PLANNERS = [
    {"name": "wave_front", "type": "wave_front_planner/WaveFrontPlanner"},
    {"name": "slow", "type": "odd/Slow"},
]
ACTIVE = (0, 1, 6, 7)
FAR = ((2.0, 2.0), (8.0, 8.0), (8.0, 2.0), (2.0, 8.0))
CANCELED = {
    "get_path": msg.GetPathResult.CANCELED,
    "exe_path": msg.ExePathResult.CANCELED,
    "recovery": msg.RecoveryResult.CANCELED,
    "move_base": msg.MoveBaseResult.CANCELED,
}
STOPPED = {
    msg.GetPathResult.STOPPED,
    msg.ExePathResult.STOPPED,
    msg.RecoveryResult.STOPPED,
}
NAMES = itertools.count()


class StormTest(unittest.TestCase):
    robot = None  # of all tests, as long as it lives

    def setUp(self):
        self.name = f"server{next(NAMES)}"
        self.server = NodeProcess(
            self.name,
            "mbf_mesh_nav",
            mesh_map={"mesh_file": MAP, "layers": LAYERS},
            planners=PLANNERS,
            slow={"seconds": 1000.0},
            planner_patience=0.0,
            robot_frame="base_footprint",
            wait={"seconds": 1000.0},
            recovery_patience=0.0,
            mesh_controller={"max_lin_velocity": 0.3},
        )
        self.addCleanup(self.server.kill)
        self.put_robot()
        self.velocities = Velocities()
        self.addCleanup(self.velocities.close)
        self.topics = {action: ActionTopics(self.name, action, self.server) for action in ACTIONS}
        for topics in self.topics.values():
            self.addCleanup(topics.close)
        self.keys = itertools.count()

        def planned():
            key = self.send("get_path", target_pose=upright(8, 8))
            self.path = self.topics["get_path"].answer(key)[1].path
            return self.path.poses

        wait_until(planned, "the robot's pose")

    @classmethod
    def put_robot(cls):
        """In the middle of the map; a new one where there is none."""
        if cls.robot is None or cls.robot.process.poll() is not None:
            name = f"robot{next(NAMES)}"
            place = {"mesh_file": MAP, "initial_pose": [5.0, 5.0, 0.0, 0.0]}
            cls.robot = NodeProcess(name, "surface_robot", scan_rate=0.0, **place)
            cls.addClassCleanup(cls.robot.kill)
            return
        wait_until(PUT.get_num_connections, "the robot")
        message = PoseWithCovarianceStamped()
        message.header.frame_id, message.pose.pose = "map", upright(5, 5).pose
        PUT.publish(message)

        def there():
            found = rospy.wait_for_message(f"/{cls.robot.name}/pose", PoseStamped, 60)
            return math.dist((found.pose.position.x, found.pose.position.y), (5, 5)) < 1e-3

        wait_until(there, "the robot in the middle")

    def send(self, action, **fields):
        return self.topics[action].send(f"{action} {next(self.keys)}", **fields)

    def check(self, action, key, state, outcome, *words):
        found, result = self.topics[action].answer(key)
        self.assertEqual((found, result.outcome), (state, outcome), result.message)
        for word in words:
            self.assertIn(word, result.message)
        return result

    def begin_all(self):
        """A long goal of each action; returns their keys."""
        keys = {
            "get_path": self.send("get_path", planner="slow", target_pose=upright(8, 8)),
            "recovery": self.send("recovery", behavior="wait"),
            "exe_path": self.send("exe_path", path=self.path, concurrency_slot=1),
        }
        wait_until(lambda: self.velocities.moving, "the drive")
        return keys

    def path_to(self, x, y):
        path = Path(poses=[upright(5, 5), upright((5 + x) / 2, (5 + y) / 2), upright(x, y)])
        path.header.frame_id = "map"
        return path

    def some_goal(self, choose):
        """A goal of any action, in one of two slots, that takes long unless it is stopped."""
        action, slot = choose.choice(list(ACTIONS)), choose.randrange(2)
        x, y = choose.choice(FAR)
        if action == "get_path":
            fields = {"planner": "slow", "target_pose": upright(x, y)}
        elif action == "exe_path":
            fields = {"path": self.path_to(x, y)}
        elif action == "recovery":
            fields = {"behavior": "wait"}
        else:
            return action, self.send(action, target_pose=upright(x, y), planner="slow")
        return action, self.send(action, concurrency_slot=slot, **fields)

    def end_all(self, sent):
        """Cancel what still runs; each goal that was sent has one answer then."""
        for action, key in sent:
            self.topics[action].cancel(key)
        for action, key in sent:
            state, result = self.topics[action].answer(key)
            self.assertIn(state, (2, 8), result.message)
            self.assertEqual(result.outcome, CANCELED[action], result.message)
            self.assertTrue(result.message)
        wait_until(lambda: self.velocities.stopped, "the stop")
        for topics in self.topics.values():
            answers = Counter({key: len(found) for key, found in topics.results.items()})
            self.assertEqual(set(answers.values()), {1})

    def test_cancels_at_random_times(self):
        choose = random.Random(1)
        sent = []
        for _ in range(200):
            action, key = self.some_goal(choose)
            sent.append((action, key))
            time.sleep(choose.choice([0.0, choose.uniform(0, 0.03)]))
            self.topics[action].cancel(key)
        self.end_all(sent)
        self.still_works()

    def test_storm(self):
        """Goals replace each other in two slots of all actions, none is canceled by a client."""
        choose = random.Random(2)
        sent = []
        for _ in range(200):
            sent.append(self.some_goal(choose))
            time.sleep(choose.choice([0.0, 0.0, choose.uniform(0, 0.02)]))
        self.end_all(sent)
        self.still_works()

    def still_works(self):
        key = self.send("get_path", target_pose=upright(3, 3))
        self.check("get_path", key, 3, 0)
        status, seconds = self.server.end()
        self.assertEqual(status, 0, self.server.output())
        self.assertNotIn("Traceback", self.server.output())

    def test_reload_while_all_work(self):
        keys = self.begin_all()
        reload = rospy.ServiceProxy(f"/{self.name}/reload_map", Trigger)
        answer = reload()
        self.assertTrue(answer.success, answer.message)
        self.assertIn("map of 441 vertices", answer.message)
        words = "loaded anew"
        self.check("get_path", keys["get_path"], 4, msg.GetPathResult.MAP_ERROR, words)
        self.check("exe_path", keys["exe_path"], 4, msg.ExePathResult.MAP_ERROR)
        self.topics["recovery"].cancel(keys["recovery"])
        self.assertIn(self.topics["recovery"].answer(keys["recovery"])[0], (2, 4))
        wait_until(lambda: self.velocities.stopped, "the stop")
        rospy.set_param(f"/{self.name}/wait/seconds", 0.01)  # read anew with the map
        rospy.set_param(f"/{self.name}/mesh_map/mesh_file", write_map(zoo.grid(cells=30)))
        answer = reload()
        self.assertIn("map of 961 vertices", answer.message)
        self.check("recovery", self.send("recovery", behavior="wait"), 3, 0)
        key = self.send("get_path", target_pose=upright(8, 8))
        self.check("get_path", key, 3, 0)
        rospy.set_param(f"/{self.name}/mesh_map/mesh_file", "/nowhere/map.h5")
        driving = self.send("move_base", target_pose=upright(8, 8))
        self.velocities.forget()
        wait_until(lambda: self.velocities.moving, "the drive")
        answer = reload()
        self.assertFalse(answer.success)
        self.assertIn("/nowhere/map.h5", answer.message)
        state, result = self.topics["move_base"].answer(driving)
        self.assertEqual(state, 4, result.message)
        self.assertTrue(result.message)
        wait_until(lambda: self.velocities.stopped, "the stop")
        key = self.send("get_path", target_pose=upright(8, 8))
        self.check("get_path", key, 4, msg.GetPathResult.MAP_ERROR, "/nowhere/map.h5")
        key = self.send("exe_path", path=self.path)
        self.check("exe_path", key, 4, msg.ExePathResult.MAP_ERROR, "/nowhere/map.h5")
        rospy.set_param(f"/{self.name}/mesh_map/mesh_file", MAP)
        self.assertTrue(reload().success)
        self.check("get_path", self.send("get_path", target_pose=upright(8, 8)), 3, 0)

    def test_signals_end_all(self):
        for by in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(by):
                self.tearDown()
                self.doCleanups()
                self.setUp()
                keys = self.begin_all()
                status, seconds = self.server.end(by)
                self.assertEqual(status, 0, self.server.output())
                for action, key in keys.items():
                    state, result = self.topics[action].answer(key)
                    self.assertEqual(state, 4)
                    self.assertIn(result.outcome, STOPPED)
                    self.assertEqual(result.message, "the server is shut down")
                wait_until(lambda: self.velocities.stopped, "the stop")
                self.assertNotIn("Traceback", self.server.output())

    def test_the_robot_goes(self):
        """Whoever knows where the robot is has died: nothing hangs, the robot stands."""
        rospy.set_param(f"/{self.name}/tf_timeout", 0.5)
        self.server.end()
        for topics in self.topics.values():
            wait_until(lambda: not topics.connected(), "the end")
        self.server = NodeProcess(self.name, "mbf_mesh_nav")
        self.addCleanup(self.server.kill)
        for topics in self.topics.values():
            wait_until(topics.connected, "the server")
        key = self.send("move_base", target_pose=upright(8, 8))
        wait_until(lambda: self.velocities.moving, "the drive")
        self.robot.kill()
        state, result = self.topics["move_base"].answer(key)
        self.assertEqual(state, 4)
        self.assertIn("base_footprint", result.message)
        wait_until(lambda: self.velocities.stopped, "the stop")


if __name__ == "__main__":
    rospy.init_node("navigation_storm_test")
    PUT = rospy.Publisher("/initialpose", PoseWithCovarianceStamped, queue_size=1)
    rostest.rosrun("mesh_navigation", "navigation_storm", StormTest)
