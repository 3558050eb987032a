#!/usr/bin/python3
"""The action exe_path, asked by a real actionlib client, with a robot that obeys."""

import itertools
import math
import random
import time
import unittest

import actionlib
import dynamic_reconfigure.client
import rospy
import rostest
import tf2_ros
from driven_robot import BareClient, DrivenRobot, ExePathClient, is_zero, path_to
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import PointCloud2
from sensor_msgs.point_cloud2 import create_cloud_xyz32
from server_process import ServerProcess, write_map
from std_msgs.msg import Float32, Header
from std_srvs.srv import Trigger

from mesh_msgs import zoo
from mesh_msgs.diagnostics_ros import ERROR
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics

NAMES = "Go Outcome Throwing Nan Deaf Slow Lame Choosy".split()
CONTROLLERS = [{"name": name.lower(), "type": f"odd/{name}Controller"} for name in NAMES]
PREEMPTED = "Goal preempted by a new plan"
STOPPED = "the robot is stopped: "


class Sensor:
    """Once it sends, ten clouds a second of one point high above the map."""

    def __init__(self, topic):
        self.frame, self.sends = "map", False
        self._publisher = rospy.Publisher(topic, PointCloud2, queue_size=1)
        self._timer = rospy.Timer(rospy.Duration(0.1), self._send)
        self.stop = self._timer.shutdown

    def _send(self, _event):
        if self.sends:
            header = Header(stamp=rospy.Time.now(), frame_id=self.frame)
            self._publisher.publish(create_cloud_xyz32(header, [(5.0, 5.0, 50.0)]))


class ExePathTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.robot = DrivenRobot()
        cls.server = ServerProcess(
            "odd_drive",
            controllers=CONTROLLERS,
            mesh_map={"mesh_file": write_map(zoo.grid())},
            tf_timeout=3.0,
            odom_timeout=3.0,
            controller_max_retries=0,
            controller_patience=1.0,
            cmd_vel_ignored_tolerance=6.0,
        )
        cls.client = ExePathClient("odd_drive")
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        moved = TransformStamped()
        moved.header.frame_id, moved.child_frame_id = "map", "moved"
        moved.transform.translation.x, moved.transform.rotation.w = 1.0, 1.0
        broadcaster.sendTransform([moved])
        cls.broadcaster = broadcaster

    @classmethod
    def tearDownClass(cls):
        try:
            status = cls.server.stop()
        finally:
            cls.server.kill()
        assert status == 0, status

    def setUp(self):
        self.robot.obeys, self.robot.seen, self.robot.behind = True, True, 0.0
        self.robot.localized = None
        self.robot.put()
        # TF of before is gone, that of now has come.
        time.sleep(0.1)

    def check(self, given, state, outcome, *words, driven=None):
        """The answer, and a robot that stands."""
        found, result = given
        self.assertEqual((found, result.outcome), (state, outcome), result.message)
        self.assertTrue(result.message)
        for word in words:
            self.assertIn(word, result.message)
        if driven:  # commands come by the guard, and so may come after the answer
            wait_until(
                lambda: any(not is_zero(each) for each in list(self.robot.commands)), "motion"
            )
        wait_until(self.robot.stands, "zero velocity")
        if driven is False:
            self.assertEqual([each for each in self.robot.commands if not is_zero(each)], [])
        return result

    def test_arrives(self):
        heard = []
        result = self.check(self.client.ask((0.8, 0.0), feedback=heard.append), "SUCCEEDED", 0)
        self.assertEqual(result.final_pose.header.frame_id, "map")
        x, y = result.final_pose.pose.position.x, result.final_pose.pose.position.y
        self.assertAlmostEqual(x, 0.75, delta=0.15)
        self.assertAlmostEqual(result.dist_to_goal, math.hypot(0.8 - x, y), places=4)
        wait_until(lambda: len(heard) > 5, "feedback")
        feedback = heard[3]
        self.assertEqual((feedback.outcome, feedback.message), (4, "3 poses, no field"))
        self.assertEqual(feedback.last_cmd_vel.header.frame_id, "base_link")
        self.assertEqual(feedback.last_cmd_vel.twist.linear.x, 0.5)
        self.assertEqual(feedback.current_pose.header.frame_id, "map")
        self.assertGreater(feedback.dist_to_goal, 0.0)

    def test_topics(self):
        heard = {}
        types = {"current_goal": PoseStamped, "go/current_angle": Float32, "go/cycle_time": Float32}
        for name, kind in types.items():
            rospy.Subscriber(
                f"/odd_drive/{name}", kind, lambda m, name=name: heard.update({name: m})
            )
        handle = self.client.send((0.9, 0.2))
        wait_until(lambda: len({*heard} - {"current_goal"}) > 1, "topics of the controller")
        self.assertEqual(heard["go/current_angle"].data, 0.25)
        self.assertLess(heard["go/cycle_time"].data, 10.0)
        self.check(self.client.answer(handle), "SUCCEEDED", 0)
        self.client.ask((1.2, 0.0))
        wait_until(lambda: "current_goal" in heard, "current_goal")
        self.assertEqual(heard["current_goal"].header.frame_id, "map")

    def test_field_of_the_plan(self):
        """A path from get_path, passed on, comes with its field."""
        state, plan = self.server.ask(
            (0.1, 0.1, 0.0), (8.0, 0.5, 0.0), planner="wave_front_planner"
        )
        self.assertEqual(state, "SUCCEEDED")
        heard = []
        handle = self.client.send(plan.path, feedback=heard.append)
        wait_until(lambda: heard, "feedback")
        self.assertIn(f"field of {len(zoo.grid().vertices)} vertices", heard[0].message)
        handle.cancel()
        self.check(self.client.answer(handle), "PREEMPTED", 101)

    def test_every_outcome(self):
        self.assertEqual(self.client.ask((5, 0), controller="outcome")[0], "SUCCEEDED")
        for outcome in range(150):
            self.robot.put()
            given = self.client.ask((outcome, 0.0), controller="outcome")
            if outcome < 10:
                self.check(given, "SUCCEEDED", 0)
            else:
                state = "PREEMPTED" if outcome == 101 else "ABORTED"
                self.check(given, state, outcome, f"outcome {outcome}, as asked", driven=False)

    def test_controllers_that_fail(self):
        for where in range(3):
            given = self.client.ask((where, 0.0), controller="throwing")
            self.check(given, "ABORTED", 114, "ZeroDivisionError: by zero")
        self.check(self.client.ask(controller="nan"), "ABORTED", 102, "not finite")
        self.check(self.client.ask(controller="lame"), "ABORTED", 112, "no legs")
        self.check(self.client.ask(controller="choosy"), "ABORTED", 110, "not this one")
        given = self.client.ask(controller="nobody")
        self.check(given, "REJECTED", 113, "no controller 'nobody'", "go, outcome")

    def test_controllers_that_block(self):
        self.check(self.client.ask(controller="deaf"), "ABORTED", 103, "controller_patience")
        self.check(self.client.ask(controller="slow"), "ABORTED", 103, "controller_patience")
        patience = dynamic_reconfigure.client.Client("/odd_drive")
        patience.update_configuration({"controller_patience": 60.0})
        try:
            for name in ("deaf", "slow"):
                handle = self.client.send(controller=name)
                wait_until(lambda: handle.get_comm_state() == actionlib.CommState.ACTIVE, name)
                time.sleep(0.4)  # then it blocks, most probably
                handle.cancel()
                self.check(self.client.answer(handle), "PREEMPTED", 101, "canceled")
        finally:
            patience.update_configuration({"controller_patience": 1.0})
            patience.close()

    def test_paths_that_are_none(self):
        self.check(self.client.ask(Path()), "ABORTED", 110, "empty")
        path = path_to(1.0, 0.0)
        path.poses[1].pose.position.y = math.nan
        self.check(self.client.ask(path), "ABORTED", 110, "pose 1", "not finite")
        path = path_to(1.0, 0.0)
        path.poses[2].pose.orientation.w = 0.0
        self.check(self.client.ask(path), "ABORTED", 110, "pose 2", "quaternion")
        path = path_to(1.0, 0.0)
        path.poses[2].header.frame_id = "moved"
        self.check(self.client.ask(path), "ABORTED", 110, "pose 2", "'moved'")
        given = self.client.ask(tolerance_from_action=True, dist_tolerance=-1.0)
        result = self.check(given, "ABORTED", 110, "tolerance of distance")
        self.assertEqual(result.final_pose.header.frame_id, "map")

    def test_a_goal_beyond_all_distances(self):
        """Farther than the numbers of messages reach."""
        heard = []
        handle = self.client.send((1e39, 0.0), feedback=heard.append)
        wait_until(lambda: heard, "feedback")
        self.assertEqual(heard[0].dist_to_goal, math.inf)
        wait_until(lambda: not self.robot.stands(), "motion")  # Else it comes in the next test.
        handle.cancel()
        result = self.check(self.client.answer(handle), "PREEMPTED", 101)
        self.assertEqual(result.dist_to_goal, math.inf)

    def test_tolerances_of_the_action(self):
        fields = {"tolerance_from_action": True, "dist_tolerance": 1.0, "angle_tolerance": 1.0}
        self.check(self.client.ask((0.9, 0.0), **fields), "SUCCEEDED", 0, driven=False)

    def test_paths_in_other_frames(self):
        result = self.check(self.client.ask(path_to(-0.3, 0.0, "moved")), "SUCCEEDED", 0)
        self.assertAlmostEqual(result.final_pose.pose.position.x, 0.7, delta=0.2)
        self.check(self.client.ask(path_to(1.0, 0.0, "nowhere")), "ABORTED", 111, "'nowhere'")
        self.check(self.client.ask(path_to(1.0, 0.0, "")), "ABORTED", 111, "frame_id")

    def test_transforms_that_fail(self):
        handle = self.client.send()
        wait_until(lambda: not self.robot.stands(), "motion")
        self.robot.seen = False
        words = "old", "odom_timeout", "tf_timeout"
        self.check(self.client.answer(handle), "ABORTED", 111, *words, driven=True)
        self.robot.seen, self.robot.behind = True, 9.0
        self.check(self.client.ask(), "ABORTED", 111, "old")
        self.robot.behind = -5.0
        time.sleep(0.1)
        self.check(self.client.ask(), "ABORTED", 111, "ahead of time")
        # Of the time that was ahead, nothing is left.
        self.robot.behind = 0.0
        time.sleep(5.2)
        self.robot.put()
        time.sleep(0.1)
        self.check(self.client.ask((0.5, 0.0)), "SUCCEEDED", 0)

    def test_gaps_in_tf(self):
        """Of a robot with odometry and a localizer: it stands meanwhile, and its goal stays."""
        self.robot.localized = 5.0
        values = {"controllers": CONTROLLERS, "tf_timeout": 60.0, "map_timeout": 10.0}
        server = ServerProcess("gaps", mesh_map={"mesh_file": write_map(zoo.grid())}, **values)
        try:
            client, heard = ExePathClient("gaps"), []
            # A localizer that is slow does not hold back where the robot is seen.
            state, result = client.ask((1.5, 0.0))
            self.assertEqual((state, result.outcome), ("SUCCEEDED", 0), result.message)
            away = abs(result.final_pose.pose.position.x - self.robot.x)
            self.assertLess(away, 1.5)  # seen as late as it is localized, it would be 2.5 m
            self.robot.put()
            handle = client.send((9.0, 0.0), feedback=heard.append)
            for attribute, gap, name in (
                ("seen", False, "odom_timeout"),
                ("localized", 50.0, "map_timeout"),
                ("behind", -1.0, "odom_timeout"),
            ):
                before = getattr(self.robot, attribute)
                wait_until(lambda: not self.robot.stands(), f"motion before {attribute}")
                setattr(self.robot, attribute, gap)
                wait_until(self.robot.stands, f"a stop for {attribute}")
                self.assertEqual(handle.get_comm_state(), actionlib.CommState.ACTIVE)
                wait_until(
                    lambda name=name: heard[-1].outcome == 111 and name in heard[-1].message,
                    f"feedback of {name}",
                )
                setattr(self.robot, attribute, before)
            wait_until(lambda: not self.robot.stands(), "motion after all of that")
            self.assertEqual(server.stop(), 0)
        finally:
            server.kill()

    def test_a_sensor_that_falls_silent(self):
        """The robot stands and its goal stays, whether clouds stop or cannot be used."""
        diagnostics, sensor = HeardDiagnostics(), Sensor("/points")
        mesh_map = {
            "mesh_file": write_map(zoo.grid()),
            "layers": [{"name": "cups", "type": "mesh_layers/ObstacleLayer"}],
            "cups": {"topic": "/points", "sensor_frame": "base_link", "robot_height": 1.0},
        }
        server = ServerProcess(
            "silent",
            mesh_map=mesh_map,
            controllers=CONTROLLERS,
            controller_patience=60.0,
            planner_patience=10.0,
        )
        try:
            client, heard = ExePathClient("silent"), []
            reason = "layer cups: nothing usable came from topic /points"
            state, result = server.ask((1, 1, 0))
            self.assertEqual((state, result.outcome), ("ABORTED", 62), result.message)
            self.assertIn(reason + " yet", result.message)
            self.assertIn("planner_patience", result.message)
            diagnostics.expected("silent: map", ERROR, reason)
            self.assertTrue(rospy.ServiceProxy("/silent/reload_map", Trigger)().success)
            handle = client.send((9.0, 0.0), feedback=heard.append)  # waits for the first cloud
            for attribute, value, words in (("sends", False, ""), ("frame", "nowhere", "nowhere")):
                before, sensor.sends = getattr(sensor, attribute), True
                self.robot.put()
                wait_until(lambda: not self.robot.stands(), f"motion before {attribute}")
                self.assertEqual(server.ask((1, 1, 0))[0], "SUCCEEDED")
                setattr(sensor, attribute, value)
                wait_until(self.robot.stands, f"a stop for {attribute}")

                def said(words=(reason + " for", words)):
                    last = heard[-1]
                    return last.outcome == 116 and all(word in last.message for word in words)

                wait_until(said, f"feedback for {attribute}")
                self.assertEqual(handle.get_comm_state(), actionlib.CommState.ACTIVE)
                setattr(sensor, attribute, before)
            sensor.sends = True
            wait_until(lambda: not self.robot.stands(), "motion after all of that")
            self.assertEqual(server.stop(), 0)
        finally:
            server.kill()
            sensor.stop()

    def test_a_robot_that_does_not_obey(self):
        self.robot.obeys = False
        given = self.client.ask()
        self.check(given, "ABORTED", 106, "cmd_vel_ignored_tolerance", driven=True)

    def test_a_new_plan_is_injected(self):
        stopped, heard = self.server.output().count(STOPPED), []
        first = self.client.send((9.0, 0.0), feedback=heard.append)
        wait_until(lambda: not self.robot.stands(), "motion")
        second = self.client.send((8.0, 0.0), controller="go", feedback=heard.append)
        self.check_preempted(first)
        third = self.client.send((0.8, 0.0), feedback=heard.append)
        self.check_preempted(second)
        # A cancel of what is over means nobody.
        first.cancel()
        self.check(self.client.answer(third), "SUCCEEDED", 0)
        # The first may be the last zeros of a drive before.
        commands = itertools.dropwhile(is_zero, self.robot.commands)
        zeros = [is_zero(twist) for twist in commands]
        late = self.server.output().count(STOPPED) > stopped  # The guard's words of the server.
        if not (late or any(each.outcome >= 10 for each in heard)):  # Or TF is, which it may be.
            self.assertEqual(zeros, sorted(zeros), "no stop in between")

    def check_preempted(self, handle):
        state, result = self.client.answer(handle)
        self.assertEqual((state, result.outcome), ("PREEMPTED", 101))
        self.assertEqual(result.message, PREEMPTED)
        self.assertEqual(result.final_pose.header.frame_id, "map")

    def test_a_new_plan_that_is_none(self):
        for bad, outcome in ((Path(), 110), (path_to(1.0, 0.0, "nowhere"), 111)):
            first = self.client.send((9.0, 0.0))
            wait_until(lambda: not self.robot.stands(), "motion")
            second = self.client.send(bad)
            self.check_preempted(first)
            self.check(self.client.answer(second), "ABORTED", outcome)

    def test_another_controller_or_slot(self):
        first = self.client.send((9.0, 0.0))
        wait_until(lambda: not self.robot.stands(), "motion")
        other = self.client.send((9.0, 0.0), controller="slow", concurrency_slot=7)
        second = self.client.send((5.0, 0.0), controller="outcome")
        self.check(self.client.answer(second), "SUCCEEDED", 0)
        state, result = self.client.answer(first)
        self.assertEqual((state, result.outcome), ("PREEMPTED", 101))
        self.assertIn("newer goal", result.message)
        other.cancel()
        self.check(self.client.answer(other), "PREEMPTED", 101)

    def test_cancels_at_random_times(self):
        rng, client = random.Random(4), BareClient("odd_drive")
        for number in range(200):
            key = f"canceled {number}"
            client.send(key, controller=("", "slow", "go")[number % 3])
            time.sleep(rng.choice((0.0, rng.uniform(0.0, 0.01), rng.uniform(0.0, 0.1))))
            client.cancel(key)
            state, result = client.answer(key)
            self.assertIn(state, ("PREEMPTED", "RECALLED"))
            self.assertEqual(result.outcome, 101)
            self.assertTrue(result.message)
            wait_until(self.robot.stands, f"zero velocity after goal {number}", 10)
            self.robot.put()
        time.sleep(0.2)
        self.assertTrue(self.robot.stands())

    def test_storm_of_goals(self):
        rng, client, keys = random.Random(5), BareClient("odd_drive"), []
        for number in range(200):
            keys.append(f"storm {number}")
            name = rng.choice(("", "", "go", "go", "outcome", "slow", "throwing", "nobody"))
            client.send(keys[-1], (rng.choice((0, 2, 3, 9)), 0.0), name)
            if rng.random() < 0.3:
                client.cancel(rng.choice(keys))
            time.sleep(rng.uniform(0.0, 0.02))
        client.cancel(keys[-1])
        for key in keys:
            state, result = client.answer(key)
            self.assertTrue(result.message)
            self.assertIn(result.outcome, (0, 101, 103, 113, 114))
        self.assertEqual((len(client.results), client.twice), (len(keys), []))
        wait_until(self.robot.stands, "zero velocity", 10)

    def test_the_map_is_replaced(self):
        reload_map = rospy.ServiceProxy("/odd_drive/reload_map", Trigger)
        handle, deaf = self.client.send((9.0, 0.0)), self.client.send(
            controller="deaf", concurrency_slot=3
        )
        wait_until(lambda: not self.robot.stands(), "motion")
        self.assertTrue(reload_map().success)
        self.check(self.client.answer(handle), "ABORTED", 116, "map")
        self.assertIn(self.client.answer(deaf)[1].outcome, (103, 116))
        # Goals of now wait for the map that comes.
        self.robot.put()
        self.check(self.client.ask((0.5, 0.0)), "SUCCEEDED", 0, driven=True)

    def test_shutdown_stops_the_robot(self):
        server = ServerProcess(
            "short_drive",
            controllers=CONTROLLERS,
            mesh_map={"mesh_file": write_map(zoo.grid())},
        )
        try:
            client = ExePathClient("short_drive")
            handle = client.send()
            other = client.send(controller="deaf", concurrency_slot=1)
            wait_until(lambda: not self.robot.stands(), "motion")
            self.assertEqual(server.stop(), 0)
            for goal in (handle, other):
                state, result = client.answer(goal)
                self.assertEqual((state, result.outcome), ("ABORTED", 117), result.message)
            wait_until(self.robot.stands, "zero velocity", 10)
        finally:
            server.kill()


if __name__ == "__main__":
    rospy.init_node("exe_path_test")
    rostest.rosrun("mesh_navigation", "exe_path", ExePathTest)
