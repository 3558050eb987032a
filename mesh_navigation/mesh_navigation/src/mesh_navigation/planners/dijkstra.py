"""Shortest paths along the edges of the mesh."""

import threading
from typing import Any, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.base.cancel import CancelFlag
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.distance.dijkstra import DijkstraField, DijkstraSolver, is_lengths_or_closed
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.path import path_length, without_repeats
from mesh_navigation.planners.path_ends import PathEnd
from mesh_navigation.planners.surface_planner import (
    CachedField,
    GivenCosts,
    RawPath,
    Search,
    SurfacePlanner,
)
from mesh_navigation.plugins.planner import PlanField
from mesh_navigation.surface.slowness import changed_vertices, is_much
from mesh_navigation.surface.up_normals import area_vectors, face_up_normals, vertex_up_normals


class DijkstraMeshPlanner(SurfacePlanner):
    """Dijkstra's algorithm over the weights of the edges, from the goal, around blocked vertices.

    From the start and to the goal the path crosses the face they lie in; between them it follows
    edges. Vertices that are lethal, unknown or over the cost limit are never passed. What an edge
    weighs is the map's to say (mesh_map.edge_weights): its length, or more where costs are high.
    """

    def _prepare(self) -> None:
        self._solvers = EdgeSolvers(self.map)
        self._solvers.newest()  # as the index: now rather than during the first plan

    def _begin(self, values: Mapping[str, Any], flag: CancelFlag, given: GivenCosts) -> Search:
        edges = self._solvers.of(given.planning)
        snapshot = given.snapshots.of(given.body.costs(edges.costs), values["cost_limit"])
        return Search(values, snapshot, edges, flag, given)

    def _solved(
        self, search: Search, target: PathEnd, vertices: Optional[List[int]]
    ) -> DijkstraField:
        return search.basis.solver.solve(
            target.corner_paths,
            vertex_costs=search.snapshot.slowness,
            targets=vertices,
            offset=search.values["goal_dist_offset"],
            cancel_flag=search.flag,
        )

    def _updated(self, search: Search, target: PathEnd, held: CachedField) -> bool:
        before, now, solver = held.search.snapshot, search.snapshot, search.basis.solver
        if is_much(changed_vertices(before, now), now):
            return False
        if now.slowness is not before.slowness or solver is not held.field.solver:
            held.field.update(now.slowness, solver=solver, cancel=search.flag)
        return True

    def _track(
        self, search: Search, origin: PathEnd, target: PathEnd, field: DijkstraField
    ) -> RawPath:
        way = np.zeros(0, dtype=np.uint32)
        cost = None
        if not origin.sees(target):
            vertex, least = first_corner(origin.corner_paths, field)
            way = field.way_from(vertex)
            cost = least if search.basis.weighted else None
        geometry = self.map.geometry
        ends = face_up_normals(geometry, [origin.face_point.face, target.face_point.face])
        points, normals = without_repeats(
            np.concatenate([origin.position[None], self.map.vertices[way], target.position[None]]),
            np.concatenate([ends[:1], vertex_up_normals(geometry, way), ends[1:]]),
        )
        return RawPath(points, normals, path_length(points) if cost is None else cost)

    def _plan_field(self, target: PathEnd, field: DijkstraField) -> PlanField:
        labels = read_only(field.potential.astype(np.float64))
        return PlanField(labels, field.limit, None, target.face_point.face, target.position)

    def _vectors(
        self, search: Search, target: PathEnd, field: DijkstraField
    ) -> Tuple[Optional[np.ndarray], Optional[np.ndarray]]:
        values = search.values
        if not (values["publish_vector_field"] or values["publish_face_vectors"]):
            return None, None
        directions = edge_directions(self.map.vertices, field.predecessors)
        faces = None
        if values["publish_face_vectors"]:
            faces = face_means(self.map.vertices, self.map.faces, directions)
        return (directions if values["publish_vector_field"] else None), faces


def first_corner(start: Sequence[Tuple[int, float]], field: DijkstraField) -> Tuple[int, float]:
    """Of the corners around the start, with their distances from it, the one to go over.

    And what the path weighs: its edges, and the lengths of the ways to and from them.
    """
    sums = [(distance + float(field.potential[vertex]), vertex) for vertex, distance in start]
    least, vertex = min(sums, key=lambda item: item[0])
    return vertex, least


class EdgeSolver(NamedTuple):
    """What one plan works with, all of one moment."""

    costs: np.ndarray
    """(V,) of the map."""
    solver: DijkstraSolver
    weighted: bool
    """Whether edges weigh other than their length (m), so that the potential is no distance."""


class EdgeSolvers:
    """Makes them for one map; may be used from several threads at once."""

    def __init__(self, mesh_map: MeshMap) -> None:
        self._map = mesh_map
        self._lock = threading.Lock()
        self._plain: Optional[DijkstraSolver] = None
        self._weights: Optional[np.ndarray] = None  # of the plan before
        self._solver: Optional[DijkstraSolver] = None  # for these

    def newest(self) -> EdgeSolver:
        """For the costs that the map has now."""
        return self.of(self._map.planning_costs())

    def of(self, snapshot: PlanningCosts) -> EdgeSolver:
        """For these costs.

        Edges of infinite weight end at vertices that are lethal or unknown, which a solver does not
        pass anyway. So where all others weigh what they are long, the one that knows lengths alone
        will do, and it is the same however often obstacles come and go.
        """
        with self._lock:
            weights = snapshot.edge_weights
            if self._weights is not weights:
                self._solver, self._weights = self._for(weights), weights
            return EdgeSolver(snapshot.costs, self._solver, self._solver is not self._plain)

    def _for(self, weights: np.ndarray) -> DijkstraSolver:
        lengths = self._map.geometry.edge_lengths
        if is_lengths_or_closed(weights, lengths):
            if self._plain is None:
                self._plain = self._made(lengths)
            return self._plain
        if self._solver is None or self._solver is self._plain:
            return self._made(weights)
        return self._solver.with_weights(weights)

    def _made(self, weights: np.ndarray) -> DijkstraSolver:
        return DijkstraSolver(topology=self._map.topology, edge_lengths=weights)


def edge_directions(vertices: np.ndarray, predecessors: np.ndarray) -> np.ndarray:
    """(V,3) float32 unit vectors to the next vertex; zero where that is the vertex itself.

    Args:
        vertices: (V,3) m.
        predecessors: (V,) the next vertex on the way to the goal.
    """
    moving = np.flatnonzero(predecessors != np.arange(len(vertices)))
    steps = vertices[predecessors[moving]] - vertices[moving]
    directions = np.zeros((len(vertices), 3), dtype=np.float32)
    directions[moving] = _units(steps)
    return directions


def face_means(vertices: np.ndarray, faces: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """(F,3) float32 unit vectors: in the plane of each face, the mean of those at its corners.

    Zero where there is none at any corner, and where the corners contradict each other.

    Args:
        vertices: (V,3) m.
        faces: (F,3).
        directions: (V,3) unit vectors or zeros.
    """
    means = np.zeros((len(faces), 3), dtype=np.float32)
    used = np.flatnonzero(directions.any(axis=1)[faces].any(axis=1))
    corners = faces[used]
    normals = _units(area_vectors(vertices, corners))
    sums = directions[corners].sum(axis=1, dtype=np.float64)
    along = sums - np.sum(sums * normals, axis=1, keepdims=True) * normals
    usable = np.linalg.norm(along, axis=1) > 1e-3
    means[used[usable]] = _units(along[usable])
    return means


def _units(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1)
