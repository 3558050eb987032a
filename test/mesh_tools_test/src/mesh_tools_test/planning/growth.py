"""How times grow with the world."""

from typing import Any, Callable, Dict, List

from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver

from mesh_tools_test.base.figures import timed
from mesh_tools_test.base.growth import Growth
from mesh_tools_test.planning import peers
from mesh_tools_test.planning.world import DISTANCE, PlanningWorld, divided, planning_world

SIZES = (10_000, 100_000, 1_000_000)  # vertices
LARGE = 10_000_000


def world_of(vertices: int) -> PlanningWorld:
    """About that many vertices; the largest by cutting each face into four."""
    if vertices > 5_000_000:
        return divided(planning_world(vertices // 2))
    return planning_world(2 * vertices)


def times(world: PlanningWorld, repeats: int) -> Dict[str, float]:
    """Milliseconds by what is done."""
    geometry, source = world.geometry, world.source
    lengths = geometry.edge_lengths
    result = {"SciPy dijkstra": scipy_time(world)}
    dijkstra = DijkstraSolver(topology=world.topology, edge_lengths=lengths)
    result["Dijkstra"] = timed(lambda: dijkstra.solve(source), repeats)[0]
    front = WaveFrontSolver.of(geometry)
    result["wave front"], field = timed(lambda: front.solve(source), repeats)
    tracer = FieldTracer.of(geometry)
    target = world.vertex_at(field.potential)
    start = world.face_at(target)
    actions: Dict[str, Callable[[], Any]] = {
        "wave front to %g m" % DISTANCE: lambda: front.solve(source, targets=[target], offset=0.3),
        "path": lambda: tracer.path(field, start),
        "directions": lambda: tracer.vertex_directions(field),
    }
    result.update({name: timed(action, repeats)[0] for name, action in actions.items()})
    return result


def scipy_time(world: PlanningWorld) -> float:
    """Milliseconds of SciPy's Dijkstra; what it needs is given back."""
    graph = peers.scipy_graph(world.topology, world.geometry.edge_lengths)
    return timed(lambda: peers.scipy_distances(graph, world.source), 1)[0]


def measured(sizes: List[int], repeats: int) -> Growth:
    """On worlds of about so many vertices."""
    columns, counts = [], []
    for size in sizes:
        world = world_of(size)
        counts.append(len(world.vertices))
        columns.append(times(world, repeats if size < LARGE else 1))
        del world
    return Growth("vertices", counts, columns)
