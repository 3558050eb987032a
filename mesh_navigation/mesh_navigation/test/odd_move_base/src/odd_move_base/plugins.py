"""Planners, controllers and behaviors whose outcomes are those of a list, again and again."""

import itertools
import math

import numpy as np

from mesh_map.base.parameter import Parameter

from mesh_navigation.base.pose import rotate
from mesh_navigation.base.robot import Velocity
from mesh_navigation.plugins.controller import Command, MeshController
from mesh_navigation.plugins.planner import MeshPlanner, PlanResult
from mesh_navigation.plugins.recovery import MeshRecovery, RecoveryResult

LIST = (
    Parameter("outcomes", "0", description="outcomes of the first, second, ... goal"),
    Parameter("seconds", 0.0, 0.0, 1000.0, "what each one takes"),
)


class _Listed:
    def initialize(self, name, mesh_map, given={}):
        complaints = super().initialize(name, mesh_map, given)
        self.outcomes = itertools.cycle(map(int, self.values["outcomes"].split()))
        return complaints


class LinePlanner(_Listed, MeshPlanner):
    """Plans straight lines."""

    parameters = LIST

    def plan(self, start, goal, tolerance, cancellation):
        outcome = next(self.outcomes)
        if cancellation.wait(self.values["seconds"]):
            return PlanResult(51, "stopped")
        if outcome >= 10:
            return PlanResult(outcome, f"plan with {outcome}")
        poses = np.zeros((5, 7))
        poses[:, :3] = np.linspace(start.position, goal.position, 5)
        poses[:, 3:] = goal.orientation
        return PlanResult(outcome, "straight", poses, 1.0)


class StraightController(_Listed, MeshController):
    """Drives straight to the goal, sideways too; or fails, or stands."""

    parameters = (*LIST, Parameter("speed", 2.0, 0.0, 10.0, "m/s"))
    outcome = None

    def set_plan(self, plan):
        if self.outcome is None:
            self.outcome = next(self.outcomes)
        self.goal = plan.goal

    def _errors(self, state):
        inverse = state.pose.orientation * [-1, -1, -1, 1]
        way = rotate(inverse, self.goal.position - state.pose.position)
        ahead = rotate(inverse, self.goal.heading)
        return way, math.atan2(ahead[1], ahead[0])

    def compute_velocity(self, state, cancellation):
        if self.outcome >= 10:
            return Command(self.outcome, f"drive with {self.outcome}")
        (x, y, _), angle = self._errors(state)
        distance = max(1e-6, math.hypot(x, y))
        speed = min(self.values["speed"], 3 * distance) / distance
        return Command(self.outcome, "straight on", Velocity(x * speed, y * speed, 3 * angle))

    def is_goal_reached(self, state, dist_tolerance, angle_tolerance):
        way, angle = self._errors(state)
        near = np.linalg.norm(way) < dist_tolerance and abs(angle) < angle_tolerance
        return bool(self.outcome < 10 and near)


class Behavior(_Listed, MeshRecovery):
    """Waits, then ends."""

    parameters = LIST

    def run(self, robot, clock, cancellation):
        outcome = next(self.outcomes)
        if cancellation.wait(self.values["seconds"]):
            return RecoveryResult(151, "stopped")
        return RecoveryResult(outcome, f"recovery with {outcome}")
