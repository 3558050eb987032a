#!/usr/bin/python3
"""Goals of exe_path that take over just when something else happens, in this process."""

import threading
import unittest

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from driving_fakes import FORWARD, PlaneRobot, Told, plan_to, values_with
from mbf_msgs.msg import ExePathGoal
from server_process import wait_until

from mesh_navigation.clock import SystemClock
from mesh_navigation.controller import Command, ControlFailure
from mesh_navigation.exe_path_node import ExePathServer
from mesh_navigation.outcomes import ExePathOutcome
from mesh_navigation.path_execution import Tolerances
from mesh_navigation.plan_store import PlanStore


class Fakes:
    """A map that is there, with one controller; as gate, map, list and ready-made plugins."""

    frame_id, names = "map", ["told"]

    def __init__(self):
        self.arrived = threading.Event()
        reached = lambda state: self.arrived.is_set()  # noqa: E731
        self.told = Told(Command(0, "", FORWARD), reached=reached)
        self.map = self.controllers = self

    def choose(self, name):
        return "told"

    why_not = choose

    def wait(self, cancellation):
        return self

    def is_current(self, ready):
        return True

    def fault(self, name):
        return None

    def __getitem__(self, name):
        return self.told


class Server(ExePathServer):
    """A path without poses is refused, but not before the test says so."""

    def __init__(self):
        self.fakes, robot = Fakes(), PlaneRobot()
        robot.frame = "map"
        values = values_with(cmd_vel_ignored_tolerance=0.0)()
        super().__init__(
            self.fakes, self.fakes, None, robot, SystemClock(), values, PlanStore()
        )
        self.refused, self.before_the_answer = threading.Event(), lambda: None

    def _prepared(self, goal, ready, cancellation):
        if goal.path.header.frame_id == "bad":
            assert self.refused.wait(60)
            raise ControlFailure(ExePathOutcome.INVALID_PATH, "no path")
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
        self.assertEqual(first.wait(timeout=60)[0], GoalStatus.PREEMPTED)

        def refuse():
            server.refused.set()
            wait_until(injected, "the refusal")

        server.before_the_answer = refuse
        server.fakes.arrived.set()
        state, result = second.wait(timeout=60)
        self.assertEqual((state, result.outcome), (GoalStatus.ABORTED, 110), result.message)
        self.assertEqual(result.message, "no path")


if __name__ == "__main__":
    rospy.init_node("take_over_test")
    rostest.rosrun("mesh_navigation", "take_over", TakeOverTest)
