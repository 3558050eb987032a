#!/usr/bin/python3
"""A server that hears whether the robot is localized."""

import itertools
import math
import unittest

import rospy
import rostest
from mbf_msgs.msg import GetPathActionResult
from mbf_msgs.srv import CheckPose
from driven_robot import path_to
from navigation_process import ActionTopics, NodeProcess
from server_process import stamped, write_map
from stepped_robot import SteppedRobot

from mesh_msgs import zoo
from mesh_msgs.diagnostics_ros import ERROR, OK, WARN
from mesh_msgs.msg import LocalizationState
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, NotLocalized, Velocity
from mesh_navigation.server.ros.localization_ros import Localization
from mesh_navigation.server.ros.robot_ros import RobotRos

LOST, UNCERTAIN, KNOWN = LocalizationState.LOST, LocalizationState.UNCERTAIN, LocalizationState.OK
SUCCEEDED, ABORTED = 3, 4
TOPIC = "/localizer/state"
MAP = write_map(zoo.grid())
WHY = "12 % of the rays are explained"
# Far more than any cycle of a busy computer takes.
PATIENT = {"odom_timeout": 20.0, "map_timeout": 20.0, "controller_patience": 60.0}


def server(name, **given):
    values = {"localization_topic": TOPIC, "localization_timeout": 1.0, **PATIENT, **given}
    values.setdefault("mesh_map", {"mesh_file": MAP, "layers": []})
    return NodeProcess(name, "mbf_mesh_nav", **values)


class Commands:
    """A guard that notes what it gets."""

    def __init__(self):
        self.sent = []

    def wait(self, cancellation):
        pass

    def send(self, drive, velocity, period):
        self.sent.append((drive, velocity))
        return velocity

    def end(self, drive):
        pass


class LocalizationTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.robot = SteppedRobot(TOPIC)
        cls.node = server("nav", planner_patience=60.0)
        cls.actions = {
            name: ActionTopics("nav", name, cls.node)
            for name in ("get_path", "exe_path", "recovery", "move_base")
        }
        cls.keys = map(str, itertools.count())
        cls.plans = []
        rospy.Subscriber("/nav/get_path/result", GetPathActionResult, cls.plans.append)

    @classmethod
    def tearDownClass(cls):
        try:
            status, _ = cls.node.end()
        finally:
            cls.node.kill()
        assert status == 0, cls.node.output()

    def setUp(self):
        self.diagnostics = HeardDiagnostics()
        self.addCleanup(self.diagnostics.unregister)
        self.robot.held = False
        self.robot.put(2.0, 5.0)
        self.robot.say(KNOWN)
        self.told(OK, "ready")

    def told(self, level, words):
        """What /diagnostics say, in a message from now on."""
        fresh = HeardDiagnostics()
        status = fresh.expected("nav: navigation", level, words)
        fresh.unregister()
        return status

    def send(self, action, **fields):
        return self.actions[action].send(next(self.keys), **fields)

    def ends(self, action, key, state, outcome, *words):
        found, result = self.actions[action].answer(key)
        self.assertEqual((found, result.outcome), (state, outcome), result.message)
        for word in words:
            self.assertIn(word, result.message)
        return result

    def path_to(self, x, y):
        plan = self.send("get_path", target_pose=stamped((x, y, 0.0)))
        return self.ends("get_path", plan, SUCCEEDED, 0).path

    def drives(self, action="exe_path", goal=(8.0, 5.0)):
        """A goal, once the robot moves."""
        self.robot.forget()
        if action == "exe_path":
            key = self.send(action, path=self.path_to(*goal))
        else:
            key = self.send(action, target_pose=stamped((*goal, 0.0)))
        wait_until(self.robot.moves, "motion")
        return key

    def stops(self, lose, words):
        """Time stands; as soon as the server has heard, no command moves the robot any more."""
        self.robot.held = True
        lose()
        status = self.told(ERROR, words)
        self.assertIn(("ready", "False"), [(value.key, value.value) for value in status.values])
        self.robot.forget()
        wait_until(self.robot.told, "zeros, while the clock stands")
        self.assertEqual(self.robot.moves(), [])
        place = self.robot.x, self.robot.y, self.robot.yaw
        self.robot.steps(40)
        self.assertEqual(self.robot.moves(), [])
        self.assertEqual((self.robot.x, self.robot.y, self.robot.yaw), place)

    def goes_on(self, says=KNOWN, reason=""):
        self.robot.forget()
        self.robot.say(says, reason)
        self.robot.held = False
        wait_until(self.robot.moves, "motion after that")

    def test_a_drive_stands_while_it_is_lost_and_arrives(self):
        key = self.drives()
        self.stops(lambda: self.robot.say(LOST, WHY), f"says {rospy.get_name()}: {WHY}")
        self.assertNotIn(key, self.actions["exe_path"].results)
        self.goes_on(UNCERTAIN, "a corridor")
        self.told(WARN, "uncertain")
        self.robot.say(KNOWN)
        result = self.ends("exe_path", key, SUCCEEDED, 0)
        self.assertLess(abs(result.final_pose.pose.position.x - 8.0), 0.15)

    def test_between_two_commands_it_is_stopped_too(self):
        """Those that move it, that is, however far their next cycle is; others are left alone."""
        topic, forward, commands = "/between/state", Velocity(0.5), Commands()
        localizer = rospy.Publisher(topic, LocalizationState, queue_size=10, latch=True)
        localization = Localization(topic, 1e6, 0.0)
        robot, going = RobotRos(commands, None, localization, "base_link", 1.0), Cancellation()
        with robot.driven(going) as moving, robot.driven(going) as standing:
            moving.drive(forward)  # nobody has spoken yet
            self.assertEqual(commands.sent, [(1, STOP)])
            for times in (1, 2):
                localizer.publish(LocalizationState(state=KNOWN))
                wait_until(lambda times=times: localization.times() == times, "a word")
                moving.drive(forward)
                standing.drive(STOP)
                robot.trail.add(Pose.at((0.0, 0.0, 0.0)))
                self.assertEqual(commands.sent[-2:], [(1, forward), (2, STOP)])
                localizer.publish(LocalizationState(state=LOST, reason=WHY))
                wait_until(lambda: commands.sent[-1] == (1, STOP), "a stop")
                moving.drive(forward)
                self.assertEqual(commands.sent[-2:], [(1, STOP), (1, STOP)])
                self.assertEqual(robot.trail.back(), [])
                with self.assertRaisesRegex(NotLocalized, WHY):
                    localization.check()

    def test_a_localizer_that_dies(self):
        key = self.drives()

        def die():
            self.robot.says = None
            self.robot.steps(25)

        self.stops(die, "has been silent on /localizer/state for")
        self.goes_on()
        self.ends("exe_path", key, SUCCEEDED, 0)

    def test_move_base_plans_anew_from_where_it_is(self):
        key = self.drives("move_base")
        plans = len(self.plans)
        self.stops(lambda: self.robot.say(LOST, WHY), WHY)
        self.assertEqual(len(self.plans), plans)
        self.robot.put(8.0, 1.0, math.pi)
        self.goes_on()
        result = self.ends("move_base", key, SUCCEEDED, 0)
        self.assertEqual(len(self.plans), plans + 1)
        end = result.final_pose.pose.position
        self.assertLess(math.hypot(end.x - 8.0, end.y - 5.0), 0.15)

    def test_a_recovery_behavior_stands(self):
        self.robot.forget()
        key = self.send("recovery", behavior="back_up")
        wait_until(self.robot.moves, "motion")
        self.stops(lambda: self.robot.say(LOST, WHY), WHY)
        self.goes_on()
        self.ends("recovery", key, SUCCEEDED, 0)

    def test_a_plan_waits_until_the_robot_is_localized(self):
        self.robot.say(LOST, WHY)
        self.told(ERROR, WHY)
        keys = [self.send("get_path", target_pose=stamped((8.0, 5.0, 0.0)))]
        ahead = stamped((1.0, 0.0, 0.0), "base_link")  # of a robot that is somewhere
        keys += [self.send("get_path", target_pose=ahead, concurrency_slot=1)]
        wait_until(lambda: self.node.output().count("is waited for") >= 1, "a word in the log")
        elsewhere = stamped((2.0, 2.0, 0.0))
        fields = {"use_start_pose": True, "start_pose": elsewhere, "concurrency_slot": 2}
        other = self.send("get_path", target_pose=stamped((8.0, 5.0, 0.0)), **fields)
        self.ends("get_path", other, SUCCEEDED, 0)  # it does not matter where the robot is
        self.assertFalse([key for key in keys if key in self.actions["get_path"].results])
        check = rospy.ServiceProxy("/nav/check_pose_cost", CheckPose)
        with self.assertRaisesRegex(rospy.ServiceException, f"tf_timeout.*{WHY}"):
            check(current_pose=True)
        self.robot.say(KNOWN)
        for key in keys:
            self.ends("get_path", key, SUCCEEDED, 0)

    def test_sensors_that_are_blind_until_the_robot_is_localized(self):
        """What is waited for is the localization, for as long as that takes."""
        layers = [{"name": "obstacles", "type": "mesh_layers/ObstacleLayer"}]
        seen = {"topic": "/cloud", "sensor_frame": "base_link", "robot_height": 1.0}
        node = server(
            "blind",
            planner_patience=0.5,
            controller_patience=0.5,
            mesh_map={"mesh_file": MAP, "layers": layers, "obstacles": seen},
            localization_patience=2.0,
        )
        self.robot.say(LOST, WHY)
        try:
            self.refused("blind", node, "(localization_patience)", WHY)
            actions = ActionTopics("blind", "get_path", node)
            start = {"use_start_pose": True, "start_pose": stamped((2.0, 2.0, 0.0))}
            key = actions.send("given", target_pose=stamped((8.0, 5.0, 0.0)), **start)
            self.assertIn("planner_patience", actions.answer(key)[1].message)
        finally:
            node.kill()

    def test_patience_that_ends(self):
        topic = "/impatient/state"
        localizer = rospy.Publisher(topic, LocalizationState, queue_size=1, latch=True)
        localizer.publish(LocalizationState(reason=WHY))
        node = server("impatient", localization_topic=topic, localization_patience=0.5)
        try:
            self.refused("impatient", node, "(localization_patience)", "silent|" + WHY)
        finally:
            node.kill()

    def test_a_localizer_that_has_never_spoken(self):
        node = server("unheard", localization_topic="nobody", tf_timeout=0.5)
        try:
            self.refused("unheard", node, "(tf_timeout)", "nothing has come on /nobody yet")
        finally:
            node.kill()

    def refused(self, name, node, parameter, reason):
        """All goals that need the robot's pose are, in time, and nothing moves."""
        target = stamped((8.0, 5.0, 0.0))
        path = path_to(8.0, 5.0)
        self.robot.forget()
        for action, outcome, fields in (
            ("get_path", 57, {"target_pose": target}),
            ("exe_path", 111, {"path": path}),
            ("move_base", 16, {"target_pose": target}),
            ("recovery", 153, {"behavior": "back_up"}),
        ):
            topics = ActionTopics(name, action, node)
            state, result = topics.answer(topics.send(f"{name} {action}", **fields))
            self.assertEqual((state, result.outcome), (ABORTED, outcome), result.message)
            self.assertRegex(result.message, reason)
            if action != "recovery":
                self.assertIn(parameter, result.message)
            topics.close()
        self.assertEqual(self.robot.moves(), [])


if __name__ == "__main__":
    rospy.init_node("localization_test")
    rostest.rosrun("mesh_navigation", "localization", LocalizationTest)
