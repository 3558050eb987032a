"""Shortest paths along the edges of the mesh."""

from typing import Any, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from mesh_map.array_checks import read_only
from mesh_map.cancel import CancelFlag
from mesh_map.dijkstra import DijkstraField

from mesh_navigation.edge_solver import EdgeSolvers
from mesh_navigation.path import path_length, without_repeats
from mesh_navigation.places import Place
from mesh_navigation.plan_field import PlanField
from mesh_navigation.planners.surface_planner import Held, Search, SurfacePlanner, Track
from mesh_navigation.slowness import changed_vertices, is_much
from mesh_navigation.up_normals import face_up_normals, vertex_up_normals
from mesh_navigation.vectors import edge_directions, face_means


class DijkstraMeshPlanner(SurfacePlanner):
    """Dijkstra's algorithm over the weights of the edges, from the goal, around blocked vertices.

    From the start and to the goal the path crosses the face they lie in; between them it follows
    edges. Vertices that are lethal, unknown or over the cost limit are never passed. What an edge
    weighs is the map's to say (mesh_map.edge_weights): its length, or more where costs are high.
    """

    def _prepare(self) -> None:
        self._solvers = EdgeSolvers(self.map)
        self._solvers.newest()  # as the index: now rather than during the first plan

    def _begin(self, values: Mapping[str, Any], flag: CancelFlag) -> Search:
        edges = self._solvers.newest()
        ground = self._grounds.of(edges.costs, values["cost_limit"])
        return Search(values, ground, edges, flag)

    def _solved(
        self, search: Search, target: Place, vertices: Optional[List[int]]
    ) -> DijkstraField:
        return search.basis.solver.solve(
            target.ways,
            vertex_costs=search.ground.slowness,
            targets=vertices,
            offset=search.values["goal_dist_offset"],
            cancel_flag=search.flag,
        )

    def _updated(self, search: Search, target: Place, held: Held) -> bool:
        before, now, solver = held.search.ground, search.ground, search.basis.solver
        if is_much(changed_vertices(before, now), now):
            return False
        if now.slowness is not before.slowness or solver is not held.field.solver:
            held.field.update(now.slowness, solver=solver, cancel=search.flag)
        return True

    def _track(self, search: Search, origin: Place, target: Place, field: DijkstraField) -> Track:
        way = np.zeros(0, dtype=np.uint32)
        cost = None
        if not origin.sees(target):
            vertex, least = _first_corner(origin.ways, field)
            way = field.way_from(vertex)
            cost = least if search.basis.weighted else None
        geometry = self.map.geometry
        ends = face_up_normals(geometry, [origin.anchor.face, target.anchor.face])
        points, normals = without_repeats(
            np.concatenate([origin.position[None], self.map.vertices[way], target.position[None]]),
            np.concatenate([ends[:1], vertex_up_normals(geometry, way), ends[1:]]),
        )
        return Track(points, normals, path_length(points) if cost is None else cost)

    def _plan_field(self, target: Place, field: DijkstraField) -> PlanField:
        labels = read_only(field.potential.astype(np.float64))
        return PlanField(labels, field.limit, None, target.anchor.face, target.position)

    def _vectors(
        self, search: Search, target: Place, field: DijkstraField
    ) -> Tuple[Optional[np.ndarray], Optional[np.ndarray]]:
        values = search.values
        if not (values["publish_vector_field"] or values["publish_face_vectors"]):
            return None, None
        directions = edge_directions(self.map.vertices, field.predecessors)
        faces = None
        if values["publish_face_vectors"]:
            faces = face_means(self.map.vertices, self.map.faces, directions)
        return (directions if values["publish_vector_field"] else None), faces


def _first_corner(start: Sequence[Tuple[int, float]], field: DijkstraField) -> Tuple[int, float]:
    """Of the corners around the start, with their distances from it, the one to go over.

    And what the path weighs: its edges, and the lengths of the ways to and from them.
    """
    sums = [(distance + float(field.potential[vertex]), vertex) for vertex, distance in start]
    least, vertex = min(sums, key=lambda item: item[0])
    return vertex, least
