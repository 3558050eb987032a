#!/usr/bin/python3
"""Goals of exe_path that take over just when something else happens, in this process."""

import gc
import math
import threading
import unittest
from contextlib import nullcontext
from unittest import mock

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from driving_fakes import FORWARD, PlaneRobot, SystemClock, Told, plan_to, values_with
from mbf_msgs.msg import ExePathGoal

from mesh_msgs.testing import wait_until
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import TAKEN_OVER, NotReady
from mesh_navigation.base.robot import STOP
from mesh_navigation.execution.path_execution import Tolerances
from mesh_navigation.execution.supervised_execution import SupervisedExecution
from mesh_navigation.plugins.controller import Command
from mesh_navigation.server.plan_store import PlanStore
from mesh_navigation.server.ros.exe_path_node import ExePathServer
from mesh_navigation.server.ros.localization_ros import Localization
from mesh_navigation.server.ros.robot_ros import RobotRos
from mesh_navigation.server.ros.slot_action_node import Parts, RunningGoal
from mesh_navigation.server.ros.velocity_commands_ros import GuardedCommands


BELIEVED = Localization("", 1.0, 0.0)  # whatever the pose is


class Patient(Told):
    def set_plan(self, plan):
        super().set_plan(plan)
        assert self.ready.wait(60)


class Fakes:
    """A map that is there, with one controller; as gate, map, list and ready-made plugins."""

    frame_id, names, gap = "map", ["told"], ""

    def __init__(self):
        self.arrived, self.ready = threading.Event(), threading.Event()
        self.ready.set()
        reached = lambda state: self.arrived.is_set()  # noqa: E731
        self.told = Patient(Command(0, "", FORWARD), reached=reached)
        self.told.ready = self.ready
        self.map = self.controllers = self

    def choose(self, name):
        return "told"

    why_not = choose

    def wait_for_data(self, _cancellation, _patience, _name):
        return self

    def fault(self, ready):
        return ""

    def __getitem__(self, name):
        return self.told


class Server(ExePathServer):
    """A path without poses is refused, but not before the test says so."""

    def __init__(self):
        self.fakes, robot = Fakes(), PlaneRobot()
        robot.frame, robot.driven = "map", lambda *_: nullcontext(robot)
        values = values_with(cmd_vel_ignored_tolerance=0.0)()
        fakes = self.fakes
        parts = Parts(
            None, fakes, None, fakes, None, BELIEVED, robot, SystemClock(), values, PlanStore()
        )
        super().__init__(parts)
        self.refused, self.before_the_answer = threading.Event(), lambda: None

    def _prepared(self, goal, ready, cancellation):
        if goal.path.header.frame_id == "bad":
            assert self.refused.wait(60)
            raise NotReady("INVALID_PATH", "no path")
        return plan_to(5.0, 0.0), Tolerances(0.1, 0.2)

    def _is_outdated(self, running):
        self.before_the_answer()
        return super()._is_outdated(running)


def goal_in(frame):
    goal = ExePathGoal()
    goal.path.header.frame_id = frame
    return goal


def injected():
    return not any(thread.name == "new plan" for thread in threading.enumerate())


class TakeOverTest(unittest.TestCase):
    def test_a_refusal_when_the_old_goal_is_just_reached(self):
        """The old path's success is none of the new one."""
        server = Server()
        server.start()
        first = server.send(goal_in("map"))
        wait_until(lambda: server.fakes.told.plans, "the drive")
        second = server.send(goal_in("bad"))
        self.assertEqual(first.wait(timeout=60).state, GoalStatus.PREEMPTED)

        def refuse():
            server.refused.set()
            wait_until(injected, "the refusal")

        server.before_the_answer = refuse
        server.fakes.arrived.set()
        end = second.wait(timeout=60)
        self.assertEqual((end.state, end.outcome), (GoalStatus.ABORTED, 110), end.message)
        self.assertEqual(end.message, "no path")

    def test_before_the_first_cycle(self):
        """The answer to the old goal knows where the robot is all the same."""
        server = Server()
        server.start()
        server.fakes.ready.clear()
        first = server.send(goal_in("map"))
        wait_until(lambda: server.fakes.told.plans, "the drive")
        second = server.send(goal_in("map"))
        end = first.wait(timeout=60)
        self.assertEqual((end.state, end.outcome), (GoalStatus.PREEMPTED, 101))
        self.assertEqual((end.message, end.drive.final_pose.header.frame_id), (TAKEN_OVER, "map"))
        self.assertTrue(math.isnan(end.drive.dist_to_goal))
        server.fakes.ready.set()
        server.fakes.arrived.set()
        self.assertEqual(second.wait(timeout=60).state, GoalStatus.SUCCEEDED)

    def test_a_shutdown_lets_nobody_drive(self):
        """Not even who is late."""
        commands = mock.Mock()
        robot = RobotRos(commands, None, BELIEVED, "base_link", 1.0)
        with robot.driven(Cancellation()) as driven:
            driven.drive(FORWARD)
            with mock.patch("rospy.core.is_shutdown_requested", return_value=True):
                driven.drive(FORWARD)
        sent = [call.args[1] for call in commands.send.call_args_list]
        self.assertEqual(sent, [FORWARD, STOP])

    def test_a_guard_that_cannot_be_started(self):
        """Nobody drives, and the refusal says why; a cancel ends the waiting."""
        module = "mesh_navigation.server.ros.velocity_commands_ros"
        # To the end of this process: it tries again and again.
        mock.patch(f"{module}._started", side_effect=OSError("no more processes")).start()
        robot = RobotRos(GuardedCommands({}), None, BELIEVED, "base_link", 1.0)
        cancellation = Cancellation()
        cancellation.cancel("enough")
        wait_until(lambda: "no more" in self.refusal(robot).message, "the reason")
        self.assertEqual(self.refusal(robot).kind, "NOT_INITIALIZED")
        refusal = self.refusal(robot, cancellation)
        self.assertEqual((refusal.kind, "enough" in refusal.message), ("CANCELED", True))

    @staticmethod
    def refusal(robot, cancellation=None):
        module = "mesh_navigation.server.ros.velocity_commands_ros"
        try:
            with mock.patch(f"{module}.DRIVE_PATIENCE", 0.1):
                with robot.driven(cancellation or Cancellation()):
                    raise AssertionError("somebody drives")
        except NotReady as refusal:
            return refusal

    def test_nothing_is_left_of_goals(self):
        server = Server()
        server.start()
        server.fakes.arrived.set()
        for number in range(30):
            server.send(goal_in("map")).wait(timeout=60)

        def left():
            gc.collect()
            kinds = (RunningGoal, SupervisedExecution)
            return [thing for thing in gc.get_objects() if isinstance(thing, kinds)]

        wait_until(lambda: not left(), "the end of all")


if __name__ == "__main__":
    rospy.init_node("take_over_test")
    rostest.rosrun("mesh_navigation", "take_over", TakeOverTest)
