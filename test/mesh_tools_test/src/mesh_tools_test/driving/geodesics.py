"""How much longer planned paths are than exact geodesics, on the open ground of a world."""

from typing import Callable, List, NamedTuple, Sequence

import numpy as np
from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from mesh_map.map.mesh_map import MeshMap
from mesh_navigation.base.path import path_length
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import POINT

from mesh_tools_test.driving import shipped
from mesh_tools_test.driving.worlds import DrivingWorld

STARTS = 40  # to each goal, so that a field of exact distances serves for many
SHORTEST = 1.0  # m
# By which a path over the faces may be shorter than a geodesic: distances are 32-bit floats. Its
# poses may be shorter by more: they leave out what they pass within 0.1 mm, such as a ridge.
IMPOSSIBLE = 1e-5
PLANNERS = ("wave_front_planner", "mmp_planner")


class Excess(NamedTuple):
    """Of one planner on one world."""

    world: str
    planner: str
    ratios: np.ndarray
    """(N,) lengths of the ways from pose to pose over those of the geodesics."""
    refused: int
    """Pairs without a plan, though there is a way."""
    impossible: int = 0
    """Paths over the faces that are shorter than the shortest."""

    @property
    def failed(self) -> bool:
        return bool(self.refused or self.impossible)


def open_ground(world: DrivingWorld) -> MeshMap:
    """The faces on which trips of a world begin and end as a mesh by itself. It has no layers: each
    meter costs a meter."""
    faces = world.mesh_map.faces[world.faces].astype(np.int64)
    used, numbers = np.unique(faces, return_inverse=True)
    return MeshMap(world.mesh_map.vertices[used], numbers.reshape(faces.shape).astype(np.uint32))


def exact_distances(ground: MeshMap, vertex: int) -> np.ndarray:
    """(V,) float32 m along the surface from a vertex, inf where none leads: windows of straight
    paths (Mitchell, Mount and Papadimitriou, 1987), which no planner uses."""
    box = ground.vertices.max(axis=0) - ground.vertices.min(axis=0)
    farthest = 20.0 * float(np.linalg.norm(box))
    front = SurfaceFront.of(ground.geometry)
    distance = ObstacleDistance(front=front, max_distance=farthest)
    is_source = np.zeros(len(ground.vertices), np.bool_)
    is_source[vertex] = True
    distance.compute(is_source)
    return distance.distances()


def excess(
    world: DrivingWorld,
    pairs: int = 1000,
    names: Sequence[str] = PLANNERS,
    seed: int = 0,
    distances: Callable[[MeshMap, int], np.ndarray] = exact_distances,
) -> List[Excess]:
    """Of each planner, for the same random pairs of vertices.

    Args:
        world: where.
        pairs: how many.
        names: of shipped planners. The robot is a point.
        seed: of the pairs.
        distances: the oracle, as `exact_distances`.
    """
    ground = open_ground(world)
    planners = [shipped.planner(ground, POINT, name) for name in names]
    ratios: List[List[float]] = [[] for _ in names]
    refused, impossible = [0 for _ in names], [0 for _ in names]
    random = np.random.default_rng(seed)
    left = pairs
    while left > 0:
        goal = int(random.integers(len(ground.vertices)))
        exact = distances(ground, goal)
        reached = np.flatnonzero(np.isfinite(exact) & (exact >= SHORTEST))
        if not len(reached):
            continue
        for start in random.choice(reached, min(STARTS, left)):
            left -= 1
            begin, end = (Pose.at(ground.vertices[one].astype(float)) for one in (start, goal))
            for number, planner in enumerate(planners):
                found = planner.make_plan(begin, end)
                if found.succeeded:
                    length, least = path_length(found.poses[:, :3]), float(exact[start])
                    ratios[number].append(length / least)
                    # The cost of a plan by length alone is at least what its path has in the faces.
                    impossible[number] += max(found.cost, length) < (1.0 - IMPOSSIBLE) * least
                else:
                    refused[number] += 1
    return [
        Excess(world.name, name, np.array(ratios[number]), refused[number], impossible[number])
        for number, name in enumerate(names)
    ]


def excess_table(some: Sequence[Excess]) -> str:
    """For people, one line for each planner on each world."""
    row = "%-12s %-20s %6s %10s %10s %10s %10s %8s %9s"
    names = "world,planner,pairs,median,over 1.01,over 1.03,worst,below 1,no plan"
    lines = [row % tuple(names.split(","))]
    for each in some:
        pairs = len(each.ratios) + each.refused
        ratios = each.ratios if len(each.ratios) else np.array([np.nan])
        shares = ("%.1f %%" % (100.0 * (ratios > bound).mean()) for bound in (1.01, 1.03))
        figures = ("%.4f" % np.median(ratios), *shares, "%.4f" % ratios.max())
        counts = each.impossible, each.refused
        lines.append(row % (each.world, each.planner, pairs, *figures, *counts))
    return "\n".join(lines)
