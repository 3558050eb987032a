"""Shortest paths along the edges of the mesh."""

from typing import Any, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from mesh_map.dijkstra import CancelFlag, DijkstraResult
from mesh_map.mesh_map import MeshMap
from mesh_map.parameter import Parameter

from mesh_navigation.anchors import Anchor, check_passable, find_anchor, passable, up_normal
from mesh_navigation.cancellation import Cancellation
from mesh_navigation.edge_solver import EdgeSolver, EdgeSolvers
from mesh_navigation.outcomes import GetPathOutcome
from mesh_navigation.path import path_length, path_poses, without_repeats
from mesh_navigation.planner import MeshPlanner, PlanFailure, PlanResult, stop_if_canceled
from mesh_navigation.pose import Pose, vector_text
from mesh_navigation.up_normals import vertex_up_normals


class Goal(NamedTuple):
    """Where the path shall end and from which vertices the search begins."""

    position: np.ndarray
    """(3,) m, on the surface."""
    normal: np.ndarray
    """(3,) of the surface there, pointing up."""
    vertex: int
    """The nearest vertex."""
    face: int
    """The face it lies in; -1: at a vertex of many."""
    seeds: List[Tuple[int, float]]
    """Passable vertices around it with the length of the straight way to it (m)."""
    remark: str
    """What to tell where this is not the goal asked for, else empty."""


class DijkstraMeshPlanner(MeshPlanner):
    """Dijkstra's algorithm over the weights of the edges, from the goal, around blocked vertices.

    From the start and to the goal the path crosses the face they lie in; between them it follows
    edges. Vertices that are lethal, unknown or over the cost limit are never passed. What an edge
    weighs is the map's to say (mesh_map.edge_weights): its length, or more where costs are high.
    """

    parameters = (
        Parameter("cost_limit", 1.0, 0.0, 10.0, "highest cost of a vertex that may be passed"),
        Parameter(
            "goal_dist_offset", 0.3, 0.0, None, "search this far beyond the start (m, weighted)"
        ),
        Parameter("publish_vector_field", False, description="compute and publish the field"),
    )

    def initialize(self, name: str, mesh_map: MeshMap, given: Mapping[str, Any] = {}) -> list:
        complaints = super().initialize(name, mesh_map, given)
        self._solvers = EdgeSolvers(mesh_map)
        self._solvers.newest()  # now rather than during the first plan
        self._normals = vertex_up_normals(mesh_map.vertices, mesh_map.faces)
        return complaints

    def plan(
        self, start: Pose, goal: Pose, tolerance: float, cancellation: Cancellation
    ) -> PlanResult:
        edges = self._solvers.newest()
        costs = edges.costs
        origin = find_anchor(self.map, start.position, "start", GetPathOutcome.INVALID_START)
        self._check(origin, costs, "start", GetPathOutcome.INVALID_START)
        seeds = self._passable_corners(origin, costs)
        try:
            target = self._goal_at(goal.position, costs)
            solution = self._solve(origin, target, edges, cancellation)
        except PlanFailure as failure:
            replaceable = (GetPathOutcome.INVALID_GOAL, GetPathOutcome.NO_PATH_FOUND)
            if tolerance == 0.0 or failure.outcome not in replaceable:
                raise
            target = self._goal_nearby(
                goal.position, tolerance, seeds, edges, cancellation, failure
            )
            solution = self._solve(origin, target, edges, cancellation)
        way = _way(origin, seeds, target, solution)
        points, normals = self._polyline(origin, way, target)
        length = path_length(points)
        straight = float(np.linalg.norm(points[-1] - points[0]))
        return PlanResult(
            outcome=GetPathOutcome.SUCCESS,
            message=f"path of {length:.2f} m with {len(points)} poses, straight it would be "
            f"{straight:.2f} m{target.remark}",
            poses=path_poses(points, normals, goal.heading),
            cost=_least_cost(seeds, solution) if edges.weighted and len(way) else length,
            potential=solution.potential,
            vector_field=self._vector_field(solution),
        )

    def _check(self, anchor: Anchor, costs: np.ndarray, what: str, outcome: int) -> None:
        check_passable(self.map, anchor, costs, self.values["cost_limit"], what, outcome)

    def _passable_corners(self, anchor: Anchor, costs: np.ndarray) -> List[Tuple[int, float]]:
        """The corners of an anchor's face that may be passed, with their distances (m)."""
        usable = passable(costs[anchor.corners], self.values["cost_limit"])
        corners = zip(anchor.corners[usable], anchor.distances[usable])
        return [(int(vertex), float(distance)) for vertex, distance in corners]

    def _goal_at(self, position: np.ndarray, costs: np.ndarray) -> Goal:
        anchor = find_anchor(self.map, position, "goal", GetPathOutcome.INVALID_GOAL)
        self._check(anchor, costs, "goal", GetPathOutcome.INVALID_GOAL)
        return Goal(
            position=anchor.position,
            normal=up_normal(self.map, anchor, self._normals),
            vertex=int(anchor.corners[0]),
            face=anchor.face,
            seeds=self._passable_corners(anchor, costs),
            remark="",
        )

    def _goal_nearby(
        self,
        position: np.ndarray,
        tolerance: float,
        start: List[Tuple[int, float]],
        edges: EdgeSolver,
        cancellation: Cancellation,
        failure: PlanFailure,
    ) -> Goal:
        """The vertex nearest to the goal that can be reached, if the tolerance allows it."""
        vertices = self.map.vertices.astype(np.float64)
        distances = np.linalg.norm(vertices - position, axis=1)
        near = np.flatnonzero(distances <= tolerance)
        if len(near):
            reached = self._distances(start, edges, cancellation)
            usable = near[np.isfinite(reached.potential[near])]
            if len(usable):
                vertex = int(usable[np.argmin(distances[usable])])
                normal = self._normals[vertex].astype(np.float64)
                remark = (
                    f"; it ends {distances[vertex]:.2f} m from the goal (tolerance "
                    f"{tolerance:.2f} m), because {failure.message}"
                )
                return Goal(vertices[vertex], normal, vertex, -1, [(vertex, 0.0)], remark)
        raise PlanFailure(
            failure.outcome,
            f"{failure.message}; of {len(near)} vertices within the tolerance of {tolerance:.2f} m "
            "none can be reached",
            failure.potential,
        )

    def _distances(
        self,
        seeds: Sequence[Tuple[int, float]],
        edges: EdgeSolver,
        cancellation: Cancellation,
        targets: Optional[Sequence[int]] = None,
    ) -> DijkstraResult:
        """Distances from the seeds; with targets, not much farther than to all of these.

        Raises:
            PlanFailure: CANCELED.
        """
        flag = CancelFlag()
        with cancellation.calling(flag.set):
            solution = edges.solver.solve(
                seeds,
                vertex_costs=edges.costs,
                cost_limit=self.values["cost_limit"],
                targets=targets,
                offset=self.values["goal_dist_offset"],
                cancel_flag=flag,
            )
        stop_if_canceled(cancellation)
        return solution

    def _solve(
        self, origin: Anchor, target: Goal, edges: EdgeSolver, cancellation: Cancellation
    ) -> DijkstraResult:
        """The search from the goal to the start.

        Raises:
            PlanFailure: it does not get there.
        """
        costs, components = edges.costs, self.map.topology.components
        start_label, goal_label = (
            int(components[vertex]) + 1 for vertex in (origin.corners[0], target.vertex)
        )
        count = self.map.topology.component_count
        if start_label != goal_label:
            raise PlanFailure(
                GetPathOutcome.NO_PATH_FOUND,
                f"no path: start is in component {start_label} of {count}, "
                f"goal in component {goal_label}",
            )
        corners = [vertex for vertex, _ in self._passable_corners(origin, costs)]
        solution = self._distances(target.seeds, edges, cancellation, corners)
        if not np.any(np.isfinite(solution.potential[corners])):
            reached = int(np.count_nonzero(np.isfinite(solution.potential)))
            size = int(np.count_nonzero(components == goal_label - 1))
            limit = self.values["cost_limit"]
            blocked = int(np.count_nonzero(~passable(costs, limit)))
            raise PlanFailure(
                GetPathOutcome.NO_PATH_FOUND,
                f"no path: {reached} of {size} vertices of component {goal_label} can be reached "
                f"from the goal, none of them at the start {vector_text(origin.position)}; "
                f"{blocked} vertices of the map are lethal, unknown or over the cost limit "
                f"{limit:.3g}",
                solution.potential,
            )
        return solution

    def _polyline(
        self, origin: Anchor, way: np.ndarray, target: Goal
    ) -> Tuple[np.ndarray, np.ndarray]:
        """(N,3) points from start over the vertices of the way to the goal, and (N,3) normals."""
        start_normal = up_normal(self.map, origin, self._normals)
        points = np.concatenate(
            [origin.position[None], self.map.vertices[way], target.position[None]]
        )
        normals = np.concatenate([start_normal[None], self._normals[way], target.normal[None]])
        return without_repeats(points, normals)

    def _vector_field(self, solution: DijkstraResult) -> Any:
        """(V,3) float32 directions to the predecessors, None unless asked for."""
        if not self.values["publish_vector_field"]:
            return None
        vertices, predecessors = self.map.vertices, solution.predecessors
        moving = np.flatnonzero(predecessors != np.arange(len(vertices)))
        steps = vertices[predecessors[moving]] - vertices[moving]
        lengths = np.linalg.norm(steps, axis=1, keepdims=True)
        field = np.zeros((len(vertices), 3), dtype=np.float32)
        field[moving] = steps / np.where(lengths > 0, lengths, 1)
        return field


def _way(
    origin: Anchor, start: Sequence[Tuple[int, float]], target: Goal, solution: DijkstraResult
) -> np.ndarray:
    """(N,) vertices to go over; none within one face that may be crossed anywhere."""
    if origin.face == target.face and len(start) == 3:
        return np.zeros(0, dtype=np.uint32)
    return solution.way_from(_first_corner(start, solution)[0])


def _first_corner(
    start: Sequence[Tuple[int, float]], solution: DijkstraResult
) -> Tuple[int, float]:
    """Of the corners around the start, with their distances from it, the one to go over."""
    return min(start, key=lambda corner: corner[1] + float(solution.potential[corner[0]]))


def _least_cost(start: Sequence[Tuple[int, float]], solution: DijkstraResult) -> float:
    """What the path minimizes: the weights of its edges, and the lengths to and from them (m)."""
    vertex, distance = _first_corner(start, solution)
    return distance + float(solution.potential[vertex])
