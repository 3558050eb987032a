"""Random trips on a world."""

from typing import List, NamedTuple

import numpy as np
from mesh_navigation.base.pose import Pose

from mesh_tools_test.driving.worlds import DrivingWorld

SHORTEST = 2.0  # m, straight from start to goal
NEAR = 10.0
_TRIES = 1000


class Trip(NamedTuple):
    """From a pose to a pose; the same seed gives the same trip on the same world."""

    seed: int
    start: Pose
    goal: Pose


def trip(world: DrivingWorld, seed: int) -> Trip:
    """A trip between places, with headings, at random; uniform over the area that is open."""
    random = np.random.default_rng(seed)
    floors = [world.faces] * 2 if world.storeys is None else world.storeys
    here, there = floors if seed % 2 == 0 else reversed(floors)
    for _ in range(_TRIES):
        start, goal = point(world, here, random), point(world, there, random)
        if world.storeys is not None or np.linalg.norm(goal - start) >= SHORTEST:
            yaws = random.uniform(-np.pi, np.pi, 2)
            return Trip(seed, Pose.at(start, float(yaws[0])), Pose.at(goal, float(yaws[1])))
    raise RuntimeError("%s: no two places %g m apart" % (world.name, SHORTEST))


def trips(world: DrivingWorld, count: int, first_seed: int = 0) -> List[Trip]:
    """Trips of that many seeds in a row."""
    return [trip(world, seed) for seed in range(first_seed, first_seed + count)]


def near_trip(world: DrivingWorld, seed: int) -> Trip:
    """A trip whose straight way is between `SHORTEST` and `NEAR`."""
    random = np.random.default_rng(seed)
    faces = world.mesh_map.faces
    for _ in range(_TRIES):
        goal = point(world, world.faces, random)
        middles = world.mesh_map.vertices[faces[world.faces, 0]]
        distances = np.linalg.norm(middles - goal.astype(np.float32), axis=1)
        near = world.faces[(distances > SHORTEST) & (distances < NEAR)]
        if len(near):
            return Trip(seed, Pose.at(point(world, near, random)), Pose.at(goal))
    raise RuntimeError("%s: no two places %g to %g m apart" % (world.name, SHORTEST, NEAR))


def point(world: DrivingWorld, faces: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """(3,) m: a point of these faces."""
    corners = world.mesh_map.vertices[world.mesh_map.faces[faces]].astype(np.float64)
    sides = corners[:, 1:] - corners[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    chosen = corners[random.choice(len(faces), p=areas / areas.sum())]
    return random.dirichlet((1.0, 1.0, 1.0)) @ chosen
