"""Times of whole fields and of what is read from them, on one thread."""

from typing import Callable, Dict, List, Tuple

import numpy as np
from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver

from mesh_tools_test.base.figures import Figure, timed
from mesh_tools_test.planning import peers
from mesh_tools_test.planning.world import PlanningWorld

SCIPY = "SciPy dijkstra"
EXACT_RADIUS = 20.0  # m


def fields(world: PlanningWorld, repeats: int) -> List[Figure]:
    """Dijkstra and the wave front over all of the world, beside SciPy."""
    geometry, source = world.geometry, world.source
    lengths = geometry.edge_lengths
    graph = peers.scipy_graph(world.topology, lengths)
    scipy, expected = timed(lambda: peers.scipy_distances(graph, source), min(repeats, 3))

    prepare, solver = timed(
        lambda: DijkstraSolver(topology=world.topology, edge_lengths=lengths), min(repeats, 3)
    )
    dijkstra, field = timed(lambda: solver.solve(source), repeats)
    if not np.allclose(field.potential, expected, rtol=1e-4):
        raise RuntimeError("Dijkstra's distances differ from SciPy's")
    front = WaveFrontSolver.of(geometry)
    wave, wave_field = timed(lambda: front.solve(source), repeats)
    finite = np.isfinite(expected)
    share = wave_field.potential[finite] / np.maximum(expected[finite], 1e-9)
    if not (share[expected[finite] > 0].max() < 1.0001 and np.median(share) > 0.8):
        raise RuntimeError("the wave front is no shorter way than edges are")
    slowness = (1.0 + world.costs).astype(np.float32)
    costs, _ = timed(lambda: front.solve(source, slowness=slowness), repeats)
    floors = (100.0, 400.0)
    return [
        Figure("Dijkstra, preparing", prepare, "ms"),
        Figure("Dijkstra, whole field", dijkstra, "ms", SCIPY, scipy, floors[0]),
        Figure("wave front, whole field", wave, "ms", SCIPY, scipy, floors[1]),
        Figure("wave front with costs", costs, "ms", "without costs", wave),
    ]


def reading(world: PlanningWorld, repeats: int) -> List[Figure]:
    """To a goal 17 m away, the path from there, and the field of directions."""
    geometry, source = world.geometry, world.source
    front = WaveFrontSolver.of(geometry)
    whole, field = timed(lambda: front.solve(source), 1)
    target = world.vertex_at(field.potential)
    solver = DijkstraSolver(topology=world.topology, edge_lengths=geometry.edge_lengths)
    all_of_it, _ = timed(lambda: solver.solve(source), 1)
    found = []
    for name, solve, peer in (
        ("Dijkstra", lambda: solver.solve(source, targets=[target], offset=0.3), all_of_it),
        ("wave front", lambda: front.solve(source, targets=[target], offset=0.3), whole),
    ):
        own, _ = timed(solve, max(repeats, 3))
        found.append(Figure("%s, to 17 m" % name, own, "ms", "whole field", peer))
    tracer = FieldTracer.of(geometry)
    start = world.face_at(target)
    own, path = timed(lambda: tracer.path(field, start), max(repeats, 3))
    if path is None or path.length < 0.5 * field.potential[target]:
        raise RuntimeError("there is no path from vertex %d" % target)
    found.append(Figure("path of %.1f m from the field" % path.length, own, "ms", floor=10.0))
    both = (tracer.vertex_directions, tracer.face_directions)
    own, _ = timed(lambda: [directions(field) for directions in both], repeats)
    found.append(Figure("directions of vertices and faces", own, "ms", floor=50.0))
    return found


def others(world: PlanningWorld, repeats: int) -> List[Figure]:
    """potpourri3d and pygeodesic where installed, and the errors of all beside the last.

    The last only so far around the source that it takes seconds.
    """
    ground = peers.snapshot_of(world)
    front = WaveFrontSolver.of(world.geometry)
    own, field = timed(lambda: front.solve(world.source), repeats)
    found = []
    results: List[Tuple[str, np.ndarray]] = [("wave front", field.labels[ground.numbers])]
    for name, prepare in peers.installed(ground):
        before, solve = timed(prepare, 1)
        other, distances = timed(lambda solve=solve: solve(ground.source), min(repeats, 2))
        found.append(Figure("wave front, whole field", own, "ms", name, other))
        found.append(Figure("  %s, preparing" % name, before, "ms"))
        results.append((name, distances))
    near = peers.snapshot_of(world, EXACT_RADIUS)
    exact = peers.exact_solver(near)
    if exact is None:
        return found
    other, expected = timed(lambda: exact(near.source), 1)
    own, _ = timed(lambda: front.solve(world.source, max_distance=EXACT_RADIUS), repeats)
    name = "wave front, to %g m" % EXACT_RADIUS
    found.append(Figure(name, own, "ms", "pygeodesic (exact)", other))
    rows = np.searchsorted(ground.numbers, near.numbers)
    return found + errors(world, expected, [(name, values[rows]) for name, values in results])


def errors(
    world: PlanningWorld, expected: np.ndarray, results: List[Tuple[str, np.ndarray]]
) -> List[Figure]:
    """Of each against exact distances beyond ten edges."""
    least = 10.0 * float(world.geometry.edge_lengths.mean(dtype=np.float64))
    far = (expected > least) & (expected <= EXACT_RADIUS)
    found = []
    for name, distances in results:
        relative = 100.0 * np.abs(distances[far] - expected[far]) / expected[far]
        own = name == "wave front"
        for text, value, floor in (
            ("mean", relative.mean(), 0.25),
            ("99th percentile", np.percentile(relative, 99), 0.6),
        ):
            title = "%s, error, %s" % (name, text)
            found.append(Figure(title, float(value), "%", floor=floor if own else None))
    return found


PARTS: Dict[str, Callable[[PlanningWorld, int], List[Figure]]] = {
    "fields": fields,
    "reading": reading,
    "others": others,
}
