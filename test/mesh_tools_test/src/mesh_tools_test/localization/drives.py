"""Robots that drive by where they are localized, beside the same drives by the truth."""

import math
from typing import Any, List, NamedTuple, Tuple

import numpy as np
from mesh_localization.tracking.localizer import (
    BaseScan,
    Localizer,
    TrackingOptions,
    TrackingState,
)
from mesh_map.map.mesh_map import MeshMap
from mesh_map.registration.rigid import motion
from mesh_map.scans.lidar import Lidar
from mesh_map.scans.tour import drivable_vertices
from mesh_map.scans.trajectory import quaternions_of, rotations_of
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import NotLocalized, RobotState
from mesh_navigation.simulation.driving import Drive, drive
from mesh_navigation.simulation.simulated_robot import SimulatedRobot
from mesh_navigation.simulation.surface_robot import SurfaceRobot

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.base.scanned_world import SENSOR_HEIGHT
from mesh_tools_test.driving import shipped
from mesh_tools_test.localization.following import ABOUT, rays_of
from mesh_tools_test.localization.worlds import DRIFT, LIDAR, RATE, LocalizationWorld

DRIVES = 30
MOST_MISSED, MOST_NEARER = 0.05, 0.03  # m, by which drives by the truth may be better
_AWAY = 6.0, 15.0  # m from start to goal
_TOLD = motion(np.array([0.1, -0.1, 0.0, 0.0, 0.0, 0.05]))  # by which the start is told wrong
_MOST_SECONDS = 120.0


class LocalizedRobot(SimulatedRobot):
    """One that knows of itself what its localization says."""

    def __init__(self, body: SurfaceRobot, world: LocalizationWorld, seed: int) -> None:
        super().__init__(body)
        self._lidar = Lidar(world.truth, LIDAR, seed=seed)
        self._random = np.random.default_rng(seed)
        self._localizer = Localizer(world.target, TrackingOptions(base_height=0.0))
        self._correction, self._reason, self._due = np.eye(4), "", 0.0
        self.moved_lost = 0.0  # m that it drove while it was lost

    def put(self, pose: Pose) -> None:
        super().put(pose)
        told = matrix_of(self.body.pose) @ _TOLD
        self._localizer.put(told, ABOUT, matrix_of(self.body.odometry), self.time)
        for _ in range(3):  # it stands until it knows where it is
            self._look()

    def state(self) -> RobotState:
        if self._reason:
            raise NotLocalized(self._reason, math.inf)
        pose = self._correction @ matrix_of(self.body.odometry)
        return RobotState(self.time, pose_of(pose), self.body.velocity)

    def advance(self, seconds: float) -> None:
        driven = self.body.driven
        super().advance(seconds)
        if self._reason:
            self.moved_lost += self.body.driven - driven
        if self.time >= self._due:
            self._due += 1 / RATE
            self._look()

    def _look(self) -> None:
        up = np.array([0.0, 0.0, SENSOR_HEIGHT])
        sensor = matrix_of(self.body.pose) @ motion(np.concatenate([up, np.zeros(3)]))
        points = self._lidar.measure(sensor).points
        chosen = points[rays_of(points, self._random)] + up
        self._localizer.move(matrix_of(self.body.odometry))
        estimate = self._localizer.add(BaseScan(chosen.astype(np.float64), up, self.time))
        assert estimate is not None
        is_lost = estimate.state == TrackingState.LOST
        self._reason = estimate.reason if is_lost else ""
        if not is_lost:
            self._correction = estimate.correction


class _Pair(NamedTuple):
    """localized: whether it arrived by its localization; missed, nearer: m by which it ended
    farther from the goal, and came nearer to lethal ground, than by the truth; moved_lost: m."""

    localized: bool
    missed: float
    nearer: float
    moved_lost: float


def matrix_of(pose: Pose) -> np.ndarray:
    """(4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotations_of(np.asarray(pose.orientation, np.float64)[None])[0]
    matrix[:3, 3] = pose.position
    return matrix


def pose_of(matrix: np.ndarray) -> Pose:
    """Of (4, 4)."""
    return Pose(matrix[:3, 3].copy(), quaternions_of(matrix[None, :3, :3])[0])


def measure(world: LocalizationWorld, count: int = DRIVES) -> List[Figure]:
    """Drives with the shipped configuration, each by its localization and by the truth; those that
    the truth does not finish are left out."""
    geometry = world.geometry
    mesh_map = shipped.shipped_map(geometry.vertices, geometry.faces)
    shape = shipped.body(mesh_map)
    planner, controller = shipped.planner(mesh_map, shape), shipped.controller(mesh_map, shape)
    pairs: List[_Pair] = []
    for number, (start, goal) in enumerate(_trips(mesh_map, 3 * count)):
        if len(pairs) == count:
            break
        body = SurfaceRobot(world.truth, start, seed=number)
        by_truth = _driven(mesh_map, planner, controller, SimulatedRobot(body), start, goal)
        if not by_truth.arrived:
            continue
        body = SurfaceRobot(
            world.truth, start, seed=number, slip=DRIFT.slip, odometry_yaw_drift=DRIFT.yaw
        )
        robot = LocalizedRobot(body, world, number)
        found = _driven(mesh_map, planner, controller, robot, start, goal)
        missed = [math.dist(each.track[-1, :3], goal.position) for each in (found, by_truth)]
        nearer = min(by_truth.clearance, 1.0) - min(found.clearance, 1.0)
        pairs.append(_Pair(found.arrived, missed[0] - missed[1], nearer, robot.moved_lost))
    name = "%s, drives by localization" % world.name
    return [
        Figure(name, len(pairs), ""),
        Figure("  not arrived", sum(not pair.localized for pair in pairs), "", floor=0),
        Figure(
            "  farther from the goal than by the truth, at most",
            1e3 * max(pair.missed for pair in pairs if pair.localized),
            "mm",
            floor=1e3 * MOST_MISSED,
        ),
        Figure(
            "  nearer to lethal ground, at most",
            1e3 * max(pair.nearer for pair in pairs),
            "mm",
            floor=1e3 * MOST_NEARER,
        ),
        Figure("  driven while lost", sum(pair.moved_lost for pair in pairs), "m"),
    ]


def _driven(
    mesh_map: MeshMap, planner: Any, controller: Any, robot: SimulatedRobot, start: Pose, goal: Pose
) -> Drive:
    return drive(
        mesh_map,
        planner,
        controller,
        start=start,
        goal=goal,
        robot=robot,
        max_time=_MOST_SECONDS,
    )


def _trips(mesh_map: MeshMap, count: int) -> List[Tuple[Pose, Pose]]:
    """Starts and goals on drivable ground."""
    random = np.random.default_rng(5)
    places = mesh_map.vertices[drivable_vertices(mesh_map.geometry)].astype(np.float64)
    trips: List[Tuple[Pose, Pose]] = []
    while len(trips) < count:
        start = places[random.integers(len(places))]
        away = np.linalg.norm(places - start, axis=1)
        goals = places[(away > _AWAY[0]) & (away < _AWAY[1])]
        if len(goals):
            goal = goals[random.integers(len(goals))]
            headings = random.uniform(-np.pi, np.pi, 2)
            trips.append((Pose.at(start, headings[0]), Pose.at(goal, headings[1])))
    return trips
