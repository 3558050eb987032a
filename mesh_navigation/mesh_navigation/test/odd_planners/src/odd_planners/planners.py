"""Planners that misbehave, each in one way."""

import ctypes
import time

import numpy as np

from mesh_map.base.parameter import Parameter

from mesh_navigation.plugins.planner import MeshPlanner, PlanResult

AT_WORK = "the planner is at work"
STRAIGHT = np.array([[0, 0, 0, 0, 0, 0, 1.0], [1, 0, 0, 0, 0, 0, 1.0]])


class OutcomePlanner(MeshPlanner):
    """Ends with the outcome that the goal's x says."""

    def plan(self, start, goal, tolerance, cancellation):
        outcome = int(goal.position[0])
        poses = STRAIGHT if outcome == 7 else np.zeros((0, 7))
        return PlanResult(outcome, f"outcome {outcome}, as asked for", poses)


class SlowPlanner(MeshPlanner):
    """Takes a while; listens to cancels."""

    parameters = (Parameter("seconds", 1.0, 0.0, 1000.0),)

    def plan(self, start, goal, tolerance, cancellation):
        if cancellation.wait(self.values["seconds"]):
            return PlanResult(51, "stopped")
        return PlanResult(0, "slow but sure", STRAIGHT, 1.0)


class DeafPlanner(MeshPlanner):
    """Takes long and does not listen."""

    parameters = (Parameter("seconds", 3.0, 0.0, 3600.0),)

    def plan(self, start, goal, tolerance, cancellation):
        print(AT_WORK, flush=True)
        time.sleep(self.values["seconds"])
        return PlanResult(0, "too late", STRAIGHT)


class ThrowingPlanner(MeshPlanner):
    """Raises what no caller expects."""

    def plan(self, start, goal, tolerance, cancellation):
        raise ZeroDivisionError("by zero")


class NanPlanner(MeshPlanner):
    """Returns poses that are none."""

    def plan(self, start, goal, tolerance, cancellation):
        return PlanResult(0, "well", STRAIGHT * np.nan)


class LamePlanner(MeshPlanner):
    """Cannot be initialized."""

    def initialize(self, name, mesh_map, given={}):
        raise RuntimeError("no legs")


class HoldingPlanner(MeshPlanner):
    """Holds Python's lock from native code; says from when on (s, monotonic)."""

    parameters = (Parameter("seconds", 0, 0, 3600),)

    def plan(self, start, goal, tolerance, cancellation):
        print(AT_WORK, flush=True)
        begin = time.monotonic()
        ctypes.PyDLL(None).sleep(self.values["seconds"])
        return PlanResult(0, str(begin), STRAIGHT, 1.0)
