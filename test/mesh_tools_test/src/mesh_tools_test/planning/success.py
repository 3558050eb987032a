"""How many paths between random places are found, at several levels of noise."""

from typing import Any, List, NamedTuple, Optional

import numpy as np
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.planning.world import PlanningWorld, planning_world

NOISE = (0.0, 0.002, 0.005, 0.01, 0.02, 0.05)  # meters of each height
GOALS, STARTS = 50, 20


class Outcome(NamedTuple):
    """Of many pairs: why the first of those that failed did, and lengths beside potentials."""

    pairs: int
    failures: List[str]
    ratios: np.ndarray  # (N,) length of each path by the potential at its start

    @property
    def share_off(self) -> float:
        """Percent of the paths whose length is over 1 % off the potential."""
        if not len(self.ratios):
            return 0.0
        return 100.0 * float((np.abs(self.ratios - 1.0) > 0.01).mean())


def fault(path: Optional[Any], start: Any, goal: Any, vertices: np.ndarray, faces: Any) -> str:
    """What is wrong with a path, "" if nothing is."""
    if path is None:
        return "no path"
    if not np.allclose(path.points[0], start.position, atol=1e-6):
        return "it does not begin at the start"
    if not np.allclose(path.points[-1], goal.position, atol=1e-6):
        return "it does not end at the goal"
    if not (np.diff(path.potentials) < 0).all():
        return "its potential does not fall everywhere"
    return "it leaves the surface" if off_surface(path, vertices, faces) > 1e-3 else ""


def off_surface(path: Any, vertices: np.ndarray, faces: np.ndarray) -> float:
    """The largest distance (m) of ends of segments from the planes and outlines of their faces."""
    corners = vertices[faces[path.faces]].astype(np.float64)
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(u, v)
    square = np.maximum(np.einsum("nd,nd->n", normal, normal), 1e-300)
    size = np.sqrt(np.maximum(np.square(u).sum(axis=1), np.square(v).sum(axis=1)))
    worst = 0.0
    for ends in (path.points[:-1], path.points[1:]):
        w = ends - a
        plane = np.abs(np.einsum("nd,nd->n", w, normal)) / np.sqrt(square)
        gamma = np.einsum("nd,nd->n", np.cross(u, w), normal) / square
        beta = np.einsum("nd,nd->n", np.cross(w, v), normal) / square
        outside = np.maximum(np.maximum(-beta, -gamma), beta + gamma - 1.0)
        thin = square < 1e-20 * size**4  # needles: their own coordinates say nothing
        worst = max(worst, float(plane.max()), float((np.maximum(outside, 0) * size)[~thin].max()))
    return worst


def tried(world: PlanningWorld, goals: int, starts: int, seed: int = 0) -> Outcome:
    """Paths from `starts` places to each of `goals` places, one field a goal."""
    random = np.random.default_rng(seed)
    front, tracer = WaveFrontSolver.of(world.geometry), FieldTracer.of(world.geometry)
    failures: List[str] = []
    ratios = []
    for goal in world.places(goals, random):
        field = front.solve(goal)
        for start in world.places(starts, random):
            path = tracer.path(field, start)
            wrong = fault(path, start, goal, world.vertices, world.faces)
            if wrong:
                failures.append("face %d to face %d: %s" % (start.face, goal.face, wrong))
            elif path is not None and path.length > 0:
                ratios.append(path.length / path.potentials[0])
    return Outcome(goals * starts, failures, np.array(ratios))


def measure(faces: int, noise: float, goals: int = GOALS, starts: int = STARTS) -> List[Figure]:
    """Failures at a level of noise."""
    outcome = tried(planning_world(faces, noise), goals, starts)
    name = "noise %g mm: no path" % (1000 * noise)
    failed = float(len(outcome.failures))
    return [
        Figure(name, failed, "of %d" % outcome.pairs, floor=0.0),
        Figure("  length over 1 % off", outcome.share_off, "%", floor=1.0),
    ]
