"""Controllers that misbehave, each in one way."""

import time

import numpy as np

from mesh_map.base.parameter import Parameter

from mesh_navigation.base.robot import Velocity
from mesh_navigation.plugins.controller import Command, ControlFailure, MeshController

FORWARD = Velocity(0.5, 0.0, 0.1)


class GoController(MeshController):
    """Drives on, until the x of the goal is reached. Its message tells of the plan."""

    def set_plan(self, plan):
        self.plan = plan
        self.current_angle = 0.25

    def is_goal_reached(self, state, dist_tolerance, angle_tolerance):
        return abs(state.pose.position[0] - self.plan.goal.position[0]) <= dist_tolerance

    def compute_velocity(self, state, cancellation):
        field = self.plan.field
        text = "no field" if field is None else f"field of {len(field.labels)} vertices"
        return Command(4, f"{len(self.plan.poses)} poses, {text}", FORWARD)


class OutcomeController(GoController):
    """Ends with the outcome that the goal's x says; a success takes three cycles."""

    def set_plan(self, plan):
        super().set_plan(plan)
        self.outcome, self.cycles = int(plan.goal.position[0]), 0

    def is_goal_reached(self, state, dist_tolerance, angle_tolerance):
        self.cycles += 1
        return self.outcome < 10 and self.cycles > 3

    def compute_velocity(self, state, cancellation):
        return Command(self.outcome, f"outcome {self.outcome}, as asked for", FORWARD)


class ThrowingController(GoController):
    """Raises what no caller expects, in the method with the number of the goal's x, after a bit."""

    def set_plan(self, plan):
        super().set_plan(plan)
        self.where, self.cycles = int(plan.goal.position[0]), 0
        self._throw(0)

    def is_goal_reached(self, state, dist_tolerance, angle_tolerance):
        self.cycles += 1
        self._throw(1)
        return False

    def compute_velocity(self, state, cancellation):
        self._throw(2)
        return super().compute_velocity(state, cancellation)

    def _throw(self, where):
        if self.where == where and (where == 0 or self.cycles > 2):
            raise ZeroDivisionError("by zero")


class NanController(GoController):
    """Commands what is no velocity, after a bit."""

    cycles = 0

    def compute_velocity(self, state, cancellation):
        self.cycles += 1
        return Command(0, "", Velocity(0.5, 0.0, np.nan) if self.cycles > 2 else FORWARD)


class DeafController(GoController):
    """After a bit, takes long and does not listen."""

    cycles = 0

    def compute_velocity(self, state, cancellation):
        self.cycles += 1
        if self.cycles > 2:
            time.sleep(3)
        return super().compute_velocity(state, cancellation)


class SlowController(GoController):
    """Takes long; listens to cancels."""

    parameters = (Parameter("seconds", 1000.0, 0.0, 1000.0),)

    def compute_velocity(self, state, cancellation):
        if cancellation.wait(self.values["seconds"]):
            return Command(101, "stopped")
        return super().compute_velocity(state, cancellation)


class LameController(GoController):
    """Cannot be initialized."""

    def initialize(self, name, mesh_map, given={}):
        raise RuntimeError("no legs")


class ChoosyController(GoController):
    """Takes no path."""

    def set_plan(self, plan):
        raise ControlFailure(110, "not this one")


class TurnController(GoController):
    """Turns on the spot, and never arrives."""

    def is_goal_reached(self, state, dist_tolerance, angle_tolerance):
        return False

    def compute_velocity(self, state, cancellation):
        return Command(0, "turning", Velocity(yaw=-0.3))
