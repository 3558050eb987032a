"""Planners that misbehave, each in one way."""

import ctypes
import sys
import time

import numpy as np

from mesh_map.base.parameter import Parameter

from mesh_navigation.plugins.planner import MeshPlanner, PlanResult

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
        _tell_of_work()
        time.sleep(self.values["seconds"])
        return PlanResult(0, "too late", STRAIGHT)


class ThrowingPlanner(MeshPlanner):
    """Raises what no caller expects."""

    def plan(self, start, goal, tolerance, cancellation):
        raise ZeroDivisionError("by zero")


class ExitingPlanner(MeshPlanner):
    """Ends the thread that it is in, as a script does that is well; when it plans, or before."""

    parameters = (Parameter("at_once", False),)

    def initialize(self, name, mesh_map, given={}):
        complaints = super().initialize(name, mesh_map, given)
        if self.values["at_once"]:
            sys.exit(0)
        return complaints

    def plan(self, start, goal, tolerance, cancellation):
        sys.exit(0)


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
        _tell_of_work()
        begin = time.monotonic()
        ctypes.PyDLL(None).sleep(self.values["seconds"])
        return PlanResult(0, str(begin), STRAIGHT, 1.0)


def _tell_of_work():
    """Who has started the process waits for it."""
    sys.stdout.write("the planner is at work\n")
    sys.stdout.flush()
