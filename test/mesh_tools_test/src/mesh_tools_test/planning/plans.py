"""Times of plans through the planner classes, from pose to poses."""

from typing import Any, Callable, Dict, List

import numpy as np
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_navigation.base.pose import Pose
from mesh_navigation.plugins.planner import MeshPlanner, PlanResult
from mesh_navigation.plugins.plugin_list import PLANNERS as PLANNER_PLUGINS, find_plugin

from mesh_tools_test.base.figures import Figure, timed
from mesh_tools_test.planning.world import CostedMap, PlanningWorld, patch

PLANNERS = {
    "Dijkstra": ("dijkstra_mesh_planner/DijkstraMeshPlanner", {}),
    "wave front": ("wave_front_planner/WaveFrontPlanner", {}),
    "pure lengths": ("cvp_mesh_planner/CVPMeshPlanner", {}),
    "exact geodesic": ("mmp_planner/MMPPlanner", {}),
}
FLOOR = 30.0  # ms, of a plan to a goal 17 m away


def planner_on(mesh_map: Any, kind: str, **parameters: Any) -> MeshPlanner:
    """A planner, ready."""
    made = find_plugin(PLANNER_PLUGINS, kind)
    complaints = made.initialize("benchmark", mesh_map, parameters)
    if complaints:
        raise RuntimeError("; ".join(complaints))
    return made


def planned(planner: MeshPlanner, start: Any, goal: Any) -> PlanResult:
    """A plan between two positions; RuntimeError if there is none."""
    result = planner.make_plan(Pose.at(start), Pose.at(goal))
    if not result.succeeded:
        raise RuntimeError(result.message)
    return result


def plans(world: PlanningWorld, repeats: int) -> List[Figure]:
    """First plans to goals 17 m away, other starts, and after a change of costs nearby."""
    field = WaveFrontSolver.of(world.geometry).solve(world.source)
    ring = np.abs(field.potential - field.potential[world.vertex_at(field.potential)])
    starts = world.vertices[np.argsort(ring)[: max(repeats, 4)]]
    goals = world.vertices[patch(world, max(repeats, 4))]
    found = []
    for name, (kind, parameters) in PLANNERS.items():
        mesh_map = CostedMap(world.geometry, world.costs)
        planner = planner_on(mesh_map, kind, **parameters)
        planned(planner, starts[0], goals[-1])
        numbers = iter(range(10**6))

        def first() -> PlanResult:
            return planned(planner, starts[0], goals[next(numbers) % len(goals)])

        def again() -> PlanResult:
            return planned(planner, starts[next(numbers) % len(starts)], goals[0])

        own, result = timed(first, len(goals))
        length = float(np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1).sum())
        found.append(Figure("%s: plan of %.1f m" % (name, length), own, "ms", floor=FLOOR))
        other, _ = timed(again, len(goals))
        found.append(Figure("  other start, same goal", other, "ms", "first plan", own))
        found.append(after_changes(world, mesh_map, planner, starts[0], goals[0], own))
    return found


def after_changes(
    world: PlanningWorld,
    mesh_map: CostedMap,
    planner: MeshPlanner,
    start: np.ndarray,
    goal: np.ndarray,
    first: float,
) -> Figure:
    """The same plan again after the costs of a hundred vertices changed half way."""
    planned(planner, start, goal)
    middle = (start + goal) / 2
    near = int(np.argmin(np.square(world.vertices - middle).sum(axis=1)))
    changed = patch(world, 100, near)
    values = iter(np.linspace(0.3, 0.9, 100))

    def change() -> PlanResult:
        mesh_map.set_costs(changed, next(values))
        return planned(planner, start, goal)

    own, _ = timed(change, 5)
    return Figure("  100 vertices changed", own, "ms", "first plan", first)


PARTS: Dict[str, Callable[[PlanningWorld, int], List[Figure]]] = {"plans": plans}
