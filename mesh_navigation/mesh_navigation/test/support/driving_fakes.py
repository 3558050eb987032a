"""A robot on a plane, clocks (one jumps from cycle to cycle), and a controller as it is told."""

import math
import time

import numpy as np

from mesh_navigation.base.clock import Clock
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, Robot, RobotLost, RobotState, Trail, Velocity
from mesh_navigation.execution.path_execution import Tolerances, default_values
from mesh_navigation.plugins.controller import Command, ControllerPlan, MeshController

FORWARD = Velocity(0.5)
TOLERANCES = Tolerances(0.1, 0.2)


def plan_to(*goal, yaw=0.0):
    """A plan of two poses, the last one at x, y."""
    pose = Pose.at([*goal, 0.0][:3], yaw)
    first = [0, 0, 0, 0, 0, 0, 1.0]
    return ControllerPlan(np.array([first, [*pose.position, *pose.orientation]]))


def values_with(**given):
    """The server's parameters."""
    values = {**default_values(), **given}
    return lambda: values


class SystemClock(Clock):
    """That of the computer, which only goes on."""

    def now(self):
        return time.monotonic()

    def wait_until(self, moment, cancellation):
        cancellation.wait(max(0.0, moment - time.monotonic()))


class PlaneRobot(Robot):
    """Drives straight ahead in its heading; obeys at once."""

    def __init__(self):
        self.trail = Trail()
        self.time, self.position, self.yaw = 0.0, np.zeros(3), 0.0
        self.command, self.commands = STOP, []
        self.measured, self.obeys, self.lost = None, True, ""

    def state(self):
        if self.lost:
            raise self.lost if isinstance(self.lost, RobotLost) else RobotLost(self.lost)
        velocity = self.command if self.measured is None else self.measured
        return RobotState(self.time, Pose.at(self.position.copy(), self.yaw), velocity)

    def drive(self, velocity):
        self.command = velocity
        self.commands.append((self.time, velocity))

    def advance(self, seconds):
        self.time += seconds
        if self.obeys:
            heading = np.array([math.cos(self.yaw), math.sin(self.yaw), 0.0])
            self.position += self.command.x * seconds * heading
            self.yaw += self.command.yaw * seconds


class SteppedClock(Clock):
    """Time passes while somebody waits; ``at`` has things to do at certain times."""

    def __init__(self, robot, at=()):
        self.robot, self._at = robot, sorted(at, key=lambda item: item[0])

    def now(self):
        return self.robot.time

    def wait_until(self, moment, cancellation):
        while self._at and self._at[0][0] <= moment:
            when, action = self._at.pop(0)
            self.robot.advance(max(0.0, when - self.robot.time))
            before = self.robot.time
            action()
            if cancellation.canceled or self.robot.time < before:
                return
        self.robot.advance(max(0.0, moment - self.robot.time))


class Told(MeshController):
    """Gives the commands it is told to, the last one again and again.

    A command may be an exception, which is raised, or a function of the state.
    """

    def __init__(self, *answers, on_plan=None, reached=None):
        self.answers = list(answers) or [Command(0, "", FORWARD)]
        self.on_plan, self.plans, self.reached, self.asked = on_plan, [], reached, 0
        self.forgotten = []

    def set_plan(self, plan):
        self.plans.append(plan)
        if self.on_plan is not None:
            raise self.on_plan

    def forget_place(self):
        self.forgotten.append(len(self.plans))

    def is_goal_reached(self, state, dist_tolerance, angle_tolerance):
        if self.reached is not None:
            return self.reached(state)
        goal = self.plans[-1].goal
        return np.linalg.norm(state.pose.position - goal.position) <= dist_tolerance

    def compute_velocity(self, state, cancellation):
        self.asked += 1
        answer = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        if isinstance(answer, BaseException):
            raise answer
        return answer(state) if callable(answer) else answer
