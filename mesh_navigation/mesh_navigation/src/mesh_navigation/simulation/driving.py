"""A whole drive without ROS.

Plan, follow the plan, and see how it went::

    from mesh_navigation.execution.planning import load_map
    from mesh_navigation.base.pose import Pose
    from mesh_navigation.simulation.driving import drive

    went = drive(load_map("garden.h5"), start=Pose.at((1, 2, 0)), goal=Pose.at((8, 9, 0.5), 1.57))
    print(went.result.message, went.planned_length, went.driven_length, went.times[-1])
"""

import copy
import math
from typing import Any, Callable, List, Mapping, NamedTuple, Optional, Tuple, Union

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import read_parameters
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.spatial_index import SpatialIndex

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import is_success
from mesh_navigation.base.path import path_length
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import POINT, Body
from mesh_navigation.execution.path_execution import (
    Cycle,
    ExecutionResult,
    PathExecution,
    Tolerances,
    default_values,
)
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.execution.server_parameters import PARAMETERS
from mesh_navigation.plugins.controller import ControllerPlan, MeshController
from mesh_navigation.plugins.planner import MeshPlanner, PlanResult
from mesh_navigation.plugins.plugin_list import CONTROLLERS, ready_plugin
from mesh_navigation.simulation.simulated_robot import STEP, SimulatedClock, SimulatedRobot
from mesh_navigation.simulation.surface_robot import SurfaceRobot

CONTROLLER = "mesh_controller/MeshController"


class Drive(NamedTuple):
    """How a drive went. N moments, one per step of the simulation."""

    result: ExecutionResult
    """Outcome and message of planning, if that failed."""
    plan: PlanResult
    """The first one."""
    cycles: List[Cycle]
    """Of the controller."""
    times: np.ndarray
    """(N,) s since the start, ascending."""
    track: np.ndarray
    """(N,7) float64: the robot's true poses, position (m) and unit quaternion x, y, z, w."""
    faces: np.ndarray
    """(N,) faces on which it was."""
    commands: np.ndarray
    """(N,3) the velocity command before each moment: x, y (m/s), yaw (rad/s)."""
    velocities: np.ndarray
    """(N,3) what the wheels did then."""
    planned_length: float
    """m, of the first plan."""
    driven_length: float
    """m on the ground, ways back too."""
    clearance: float
    """m: the smallest distance of the track from a lethal or unknown vertex, by the costs at the
    end; inf where there is none."""
    blocked: np.ndarray
    """Indices of the moments at which it was on lethal or unknown ground, by the costs then."""

    @property
    def arrived(self) -> bool:
        """Whether it was a success."""
        return is_success(self.result.outcome)


def make_controller(
    mesh_map: MeshMap,
    controller: str = CONTROLLER,
    parameters: Mapping[str, Any] = {},
    body: Body = POINT,
) -> MeshController:
    """A controller for many drives on one map.

    Args:
        mesh_map: with its layers computed.
        controller: type of any plugin.
        parameters: of the controller, those that differ from their defaults.
        body: of the robot on that map.

    Raises:
        MeshMapError: no such controller, or a name or value that is none of its parameters.
    """
    return ready_plugin(CONTROLLERS, controller, mesh_map, parameters, body=body)


def drive(
    mesh_map: MeshMap,
    planner: Union[str, MeshPlanner] = "wave_front",
    controller: Union[str, MeshController] = CONTROLLER,
    *,
    start: Pose,
    goal: Pose,
    values: Mapping[str, Any] = {},
    robot: Optional[SimulatedRobot] = None,
    max_time: float = 600.0,
    on_step: Callable[[float, SimulatedRobot], None] = lambda time, robot: None,
    **body: Any,
) -> Drive:
    """Plan, and drive there in simulated time, as fast as the computer can, in this thread.

    With ``planner_frequency`` above 0 it is planned anew while it drives, as move_base does; a new
    plan that fails is left out.

    Args:
        mesh_map: the map.
        planner: one of `mesh_navigation.execution.planning.SHORT_NAMES`, the type of any plugin, or
            a planner that is initialized.
        controller: the type of any plugin, or a controller that is initialized; a copy drives.
        start: where the robot is put.
        goal: where to arrive, and with which heading.
        values: parameters of the server that differ from their defaults: tolerances, frequencies.
        robot: one of one's own, which is put at the start; None: a `SurfaceRobot` made with
            ``**body`` (seed, slip, noise, limits, ...).
        max_time: simulated s, after which the drive is canceled.
        on_step: called after each step of the simulation with the time and the robot: to watch, to
            change costs, to push the robot.

    Raises:
        MeshMapError: what cannot be used.
    """
    settings, complaints = read_parameters(PARAMETERS, values, default_values())
    for complaint in complaints:
        raise MeshMapError(f"parameter {complaint}")
    if isinstance(planner, str):
        planner = make_planner(mesh_map, planner)
    if isinstance(controller, str):
        controller = make_controller(mesh_map, controller)
    if robot is None:
        robot = SimulatedRobot(SurfaceRobot(mesh_map, start, **body))
    elif body:
        raise MeshMapError(f"{', '.join(body)}: not for a robot of one's own")
    else:
        robot.put(start)
    made = _Simulation(mesh_map, robot, planner, goal, settings, on_step)
    return made.run(copy.copy(controller), max_time)


class _Simulation:
    def __init__(
        self,
        mesh_map: MeshMap,
        robot: SimulatedRobot,
        planner: MeshPlanner,
        goal: Pose,
        values: Mapping[str, Any],
        on_step: Callable[[float, SimulatedRobot], None],
    ) -> None:
        self._map, self._robot, self._planner, self._goal = mesh_map, robot, planner, goal
        self._values, self._watch = values, on_step
        self._cancellation = Cancellation()
        self._tolerances = Tolerances(values["dist_tolerance"], values["angle_tolerance"])
        self._cycles: List[Cycle] = []
        self._execution = PathExecution(
            robot,
            SimulatedClock(robot, self._on_step, STEP),
            lambda: values,
            self._cycles.append,
            lambda: mesh_map.lasting_fault,
            lambda: mesh_map.gap,
        )
        self._moments: List[Tuple[Any, ...]] = []
        self._blocked: List[int] = []
        self._begin = robot.time
        self._driven = robot.body.driven
        frequency = values["planner_frequency"]
        self._period = 1 / frequency if frequency > 0 else math.inf
        self._next_plan = self._period

    def run(self, controller: MeshController, max_time: float) -> Drive:
        self._max_time = max_time
        self._note()
        plan = self._planned()
        if plan.succeeded:
            result = self._execution.run(
                controller,
                ControllerPlan(plan.poses, plan.plan_field),
                self._tolerances,
                self._cancellation,
            )
        else:
            result = ExecutionResult(plan.outcome, plan.message, None, math.nan, math.nan)
        times, positions, turns, faces, commands, velocities = zip(*self._moments)
        track = np.concatenate([positions, turns], axis=1)
        distances = clearances(self._map, track[:, :3])
        return Drive(
            result,
            plan,
            self._cycles,
            np.array(times),
            track,
            np.array(faces),
            np.array(commands),
            np.array(velocities),
            path_length(plan.poses[:, :3]) if plan.succeeded else 0.0,
            self._robot.body.driven - self._driven,
            float(distances.min()),
            np.array(self._blocked, dtype=np.int64),
        )

    def _planned(self) -> PlanResult:
        return self._planner.make_plan(
            self._robot.state().pose, self._goal, cancellation=self._cancellation
        )

    def _note(self) -> None:
        body = self._robot.body
        if on_blocked(self._map, body.place):
            self._blocked.append(len(self._moments))
        time = self._robot.time - self._begin
        command = self._robot.last_command
        self._moments.append((time, *body.pose, body.place.face, command, body.velocity))

    def _on_step(self, moment: float) -> None:
        self._note()
        time = moment - self._begin
        self._watch(time, self._robot)
        if time >= self._max_time:
            self._cancellation.cancel(f"{self._max_time:.1f} s of simulated time are over")
        elif time >= self._next_plan:
            self._next_plan += self._period
            plan = self._planned()
            if plan.succeeded:
                newer = ControllerPlan(plan.poses, plan.plan_field)
                self._execution.replace(self._execution.prepared(newer), self._tolerances)


def clearances(mesh_map: MeshMap, positions: np.ndarray) -> np.ndarray:
    """(N,) m from each of (N,3) positions to the nearest lethal or unknown vertex; inf if none."""
    blocked = np.flatnonzero(~np.isfinite(mesh_map.planning_costs().costs))
    if not len(blocked):
        return np.full(len(positions), np.inf)
    # Faces that are points: the index finds the nearest without looking at all of them.
    points = np.repeat(np.arange(len(blocked))[:, None], 3, axis=1)
    index = SpatialIndex(mesh_map.vertices[blocked], points, device="off")
    return index.closest_batch(points=positions).distances


def on_blocked(mesh_map: MeshMap, place: Any) -> bool:
    """Whether a place of the surface is blocked: the nearest corner of its face, that of the
    largest weight, is lethal or unknown.

    Args:
        mesh_map: the map.
        place: what has a face and barycentric coordinates.
    """
    vertex = mesh_map.faces[place.face, place.barycentric.argmax()]
    return not math.isfinite(mesh_map.planning_costs().costs[vertex])
