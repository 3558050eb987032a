"""What a control cycle takes on a large map, in one process and without ROS."""

from typing import Any, List, NamedTuple

import numpy as np
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.simulation.driving import drive, make_controller

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.base.noisy_world import map_with, noisy_world
from mesh_tools_test.driving.trips import Trip, trip
from mesh_tools_test.driving.worlds import DrivingWorld, layer, robot_layers

FLOOR = 5.0  # ms, of 99 of 100 cycles
NEW_COSTS = 0.1  # s from one change to the next
SEEN = 1.0  # m around the middle of what stands there
FARTHEST = 8.0  # m from the middle of the way


class Timed(NamedTuple):
    """One drive."""

    milliseconds: np.ndarray
    """(N,) of each cycle."""
    changes: int
    """How often the costs of the map changed meanwhile."""
    seconds: float
    """Simulated."""


def large_world(faces: int) -> DrivingWorld:
    """The outdoor world with noise, and an obstacle layer that nobody feeds."""
    rough = noisy_world(faces)
    layers = robot_layers(step=0.4)
    layers.insert(-1, layer("obstacle", "Obstacle", robot_height=1.5, clearing=False, decay=-1.0))
    geometry = MeshGeometry(rough.vertices, rough.faces)
    return DrivingWorld("large", map_with(geometry, layers))


def timed_drive(world: DrivingWorld, wanted: Trip, busy: bool) -> Timed:
    """Drive, and note what each cycle took.

    Args:
        world: with an obstacle layer.
        wanted: where from and where to.
        busy: whether costs beside the way change ten times a second and a new plan comes every
            second, all of it between cycles: what a cycle then has to do again is in its time.
    """
    planner, controller = make_planner(world.mesh_map), make_controller(world.mesh_map)
    obstacles = Obstacles(world, planner.make_plan(wanted.start, wanted.goal).poses)
    went = drive(
        world.mesh_map,
        planner,
        controller,
        start=wanted.start,
        goal=wanted.goal,
        values={"planner_frequency": 1.0 if busy else 0.0},
        on_step=lambda now, robot: obstacles.at(now) if busy else None,
    )
    obstacles.remove()
    if not went.arrived:
        message = went.result.message
        raise RuntimeError("seed %d: outcome %d, %s" % (wanted.seed, went.result.outcome, message))
    taken = np.array([1000.0 * cycle.seconds for cycle in went.cycles])
    return Timed(taken, obstacles.changes, float(went.times[-1]))


class Obstacles:
    """Something beside a way that is now here, now a little farther."""

    def __init__(self, world: DrivingWorld, poses: np.ndarray) -> None:
        """Args:
        world: with an obstacle layer.
        poses: (N,7) of the way.
        """
        self._map, self.changes, self._next = world.mesh_map, 0, NEW_COSTS
        vertices, way = self._map.vertices, poses[:, :3]
        middle = way[len(way) // 2]
        near = np.flatnonzero(np.linalg.norm(vertices - middle, axis=1) < FARTHEST)
        some = vertices[near[:: max(1, len(near) // 500)]]
        clear = np.linalg.norm(some[:, None] - way[None], axis=2).min(axis=1)
        there = np.linalg.norm(vertices - some[np.argmax(clear)], axis=1) < SEEN
        left = vertices[:, 0] < some[np.argmax(clear), 0]
        above = vertices.astype(np.float64) + (0.0, 0.0, 0.4)
        self._clouds = [above[there & left], above[there & ~left]]
        self._origin = middle + (0.0, 0.0, 1.0)

    def at(self, now: float) -> None:
        """What a sensor tells at that time (s)."""
        if now >= self._next - 1e-9:
            self._next += NEW_COSTS
            self._insert(self._clouds[self.changes % 2], now)
            self.changes += 1

    def remove(self) -> None:
        """All of it."""
        self._insert(np.zeros((0, 3)), self._next)

    def _insert(self, points: np.ndarray, now: float) -> None:
        one: Any = self._map.layers["obstacle"]
        one.insert_cloud(self._map, points, self._origin, now)
        self._map.refresh_layer("obstacle")


def cycles(faces: int, count: int) -> List[Figure]:
    """Times of cycles, over that many drives; while nothing changes, and while all does."""
    world = large_world(faces)
    found = []
    for text, busy in (("control cycle", False), ("with new costs and plans", True)):
        drives = [timed_drive(world, trip(world, seed), busy) for seed in range(count)]
        times = np.concatenate([each.milliseconds for each in drives])
        p50, p99 = np.percentile(times, (50, 99))
        found += [
            Figure("%s: median of %d" % (text, len(times)), float(p50), "ms"),
            Figure("  99 %", float(p99), "ms", floor=FLOOR),
            Figure("  longest", float(times.max()), "ms"),
        ]
    found.append(Figure("  changes of costs", float(sum(each.changes for each in drives)), ""))
    return found
