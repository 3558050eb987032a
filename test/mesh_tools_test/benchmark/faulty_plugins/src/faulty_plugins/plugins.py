"""A layer, a planner and a controller that fail when they are told to, and note when they did."""

import ctypes
import os
import time
from typing import Any

import numpy as np
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Layer, LayerResult
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.robot import RobotState
from mesh_navigation.controllers.mesh_controller import MeshController
from mesh_navigation.plugins.controller import Command
from mesh_navigation.plugins.planner import MeshPlanner, PlanResult

FILE = Parameter("file", "", description="gets the moment of the fault (s, monotonic)")


def note(path: str) -> None:
    """Write the moment; whoever reads the file finds all of it or nothing."""
    with open(path + ".new", "w", encoding="ascii") as file:
        file.write(repr(time.monotonic()))
    os.replace(path + ".new", path)


class FailingLayer(Layer):
    """Free; fails as long as its file is there, when a layer that it reads changes."""

    PARAMETERS = (FILE,)
    READS_LAYERS = True

    def compute(self, mesh_map: Any, inputs: Any) -> LayerResult:
        path = self.params["file"]
        if os.path.exists(path):
            note(path)
            raise RuntimeError("told to fail")
        return LayerResult.free(len(mesh_map.vertices))


class HoldingPlanner(MeshPlanner):
    """Holds Python's lock from native code, and has no plan."""

    parameters = (FILE, Parameter("seconds", 8, 0, 100))

    def plan(self, start: Any, goal: Any, tolerance: float, cancellation: Any) -> PlanResult:
        note(self.values["file"])
        ctypes.PyDLL(None).sleep(self.values["seconds"])
        return PlanResult(54, "no plan was looked for", np.zeros((0, 7)))


class BlockingController(MeshController):
    """Drives; when its file is there, and as long as it is, it does not answer."""

    parameters = (*MeshController.parameters, FILE)

    def compute_velocity(self, state: RobotState, cancellation: Cancellation) -> Command:
        path = self.values["file"]
        if os.path.exists(path):
            note(path)
            while os.path.exists(path):
                time.sleep(0.01)
        return super().compute_velocity(state, cancellation)
