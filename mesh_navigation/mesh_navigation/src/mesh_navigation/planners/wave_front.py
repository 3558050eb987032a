"""Shortest and safest paths across the faces of the mesh."""

from typing import Any, List, Mapping, Optional, Tuple

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.parameter import Parameter
from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.distance.exact_geodesic import ExactGeodesic
from mesh_map.distance.surface_path import FieldTracer, SurfacePath
from mesh_map.distance.wave_front import WaveFrontField, WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry

from mesh_navigation.base.path import path_length, spaced_out
from mesh_navigation.planners.dijkstra import first_corner
from mesh_navigation.planners.path_ends import PathEnd
from mesh_navigation.planners.surface_planner import (
    PARAMETERS,
    CachedField,
    GivenCosts,
    RawPath,
    Search,
    SurfacePlanner,
)
from mesh_navigation.plugins.planner import PlanField
from mesh_navigation.surface.slowness import changed_vertices
from mesh_navigation.surface.travel_cost import travel_cost
from mesh_navigation.surface.up_normals import face_up_normals

# More than this share over its potential, a path is looked at again.
_SUSPECT = 0.01

STEP_WIDTH = Parameter("step_width", 0.4, 0.01, 1.0, "longest way from a pose to the next (m)")


def _cost_factor(default: float) -> Parameter:
    text = "a meter where the cost is c counts as 1 + cost_factor c meters; 0 is pure length"
    return Parameter("cost_factor", default, 0.0, 100.0, text)


class WaveFrontPlanner(SurfacePlanner):
    """A front that spreads from the goal over the surface, and the path down its potential.

    The front takes 1 + cost_factor c times as long where the cost is c, so that the path weighs
    length against risk. Vertices that are lethal, unknown or over the cost limit are not reached,
    and a face with such a corner is not crossed. The path lies in the faces; its poses are where it
    bends, and at most step_width apart. Its cost is the potential at the start, or that of the path
    where that is more: on large faces a potential may promise what there is no path for. Where that
    is more than a hundredth, the path is pulled taut (where only lengths count), and what is left
    is said in the message.
    """

    parameters = PARAMETERS + (STEP_WIDTH, _cost_factor(1.0))

    def _prepare(self) -> None:
        geometry = self.map.geometry
        self._solver = WaveFrontSolver.of(geometry)
        self._tracer = FieldTracer.of(geometry)

    def _begin(self, values: Mapping[str, Any], flag: CancelFlag, given: GivenCosts) -> Search:
        costs = given.body.costs(given.planning.costs)
        snapshot = given.snapshots.of(costs, values["cost_limit"], self._factor(values))
        return Search(values, snapshot, snapshot, flag, given)

    def _factor(self, values: Mapping[str, Any]) -> float:
        return values["cost_factor"]

    def _solved(
        self, search: Search, target: PathEnd, vertices: Optional[List[int]]
    ) -> WaveFrontField:
        return self._solver.solve(
            target.face_point if target.whole else _seeds(target, search.snapshot.slowness),
            slowness=search.snapshot.slowness,
            targets=vertices,
            offset=search.values["goal_dist_offset"],
            cancel=search.flag,
        )

    def _updated(self, search: Search, target: PathEnd, held: CachedField) -> bool:
        changed = changed_vertices(held.search.snapshot, search.snapshot)
        if not target.whole and np.isin(target.vertices, changed).any():
            return False  # the front begins with other values
        if len(changed):
            held.field.update(search.snapshot.slowness, changed, cancel=search.flag)
        return True

    def _track(
        self, search: Search, origin: PathEnd, target: PathEnd, field: WaveFrontField
    ) -> RawPath:
        path = self._surface_path(search, origin, target, field)
        if len(path.points) == 1:  # the start is the goal
            ends = np.stack([origin.position, target.position])
            path = SurfacePath(ends, np.array([target.face_point.face]), np.zeros(2))
        promised = float(path.potentials[0])
        snapshot, geometry = search.snapshot, self.map.geometry
        cost = travel_cost(geometry, path, snapshot.slowness)
        if cost > (1 + _SUSPECT) * promised and snapshot.is_length:
            path = self._tightened(search, origin, target, path, _SUSPECT)
            cost = travel_cost(geometry, path, snapshot.slowness)
        points, segments = spaced_out(path.points, search.values["step_width"])
        normals = face_up_normals(self.map.geometry, path.faces[segments])
        remark = ""
        if cost > (1 + _SUSPECT) * promised:
            remark = f"; the potential promised {promised:.2f}, faces here are too large for it"
            remark += " (max_edge_length of the map makes them smaller)"
        # No meter takes less than 1; the last digits depend on where the poses are.
        return RawPath(points, normals, max(promised, cost, path_length(points)), remark)

    def _surface_path(
        self, search: Search, origin: PathEnd, target: PathEnd, field: WaveFrontField
    ) -> SurfacePath:
        """The path in the faces; its potentials are what it costs from there."""
        return self._tracer.path(_to_goal(field, target), origin.face_point, cancel=search.flag)

    def _tightened(
        self, search: Search, origin: PathEnd, target: PathEnd, path: SurfacePath, slack: float
    ) -> SurfacePath:
        """A path down a potential of lengths, pulled taut.

        Where it is still longer than its potential promised, by more than a share `slack`: or what
        is pulled taut from the way over edges, if that is shorter. That is never longer than over
        edges, and may be on a better side of a hill.
        """
        taut = self._taut(search, path)
        if taut.length <= (1 + slack) * path.potentials[0]:
            return taut
        other = self._taut(search, self._along_edges(search, origin, target))
        return min(taut, other, key=lambda candidate: candidate.length)

    def _taut(self, search: Search, path: SurfacePath) -> SurfacePath:
        """The locally shortest path, over what may be passed, that a path becomes."""
        geodesic = ExactGeodesic.of(self.map.geometry)
        return geodesic.shorten(path, mask=search.snapshot.open_faces, cancel=search.flag)

    def _along_edges(self, search: Search, origin: PathEnd, target: PathEnd) -> SurfacePath:
        """The shortest way over edges, as Dijkstra's algorithm finds it."""
        geometry = self.map.geometry
        found = geometry.made(_edge_solver).solve(
            target.corner_paths,
            vertex_costs=search.snapshot.slowness,
            targets=origin.vertices,
            cancel_flag=search.flag,
        )
        way = found.way_from(first_corner(origin.corner_paths, found)[0])
        points = np.concatenate(
            [origin.position[None], geometry.vertices[way], target.position[None]]
        )
        faces_of = geometry.topology.faces_of
        between = [
            np.intersect1d(faces_of(a), faces_of(b))[0]
            for a, b in zip(way.tolist(), way[1:].tolist())
        ]
        faces = np.array(
            [origin.face_point.face, *between, target.face_point.face], dtype=np.uint32
        )
        return SurfacePath(points, faces, np.zeros(len(points)))

    def _plan_field(self, target: PathEnd, field: WaveFrontField) -> PlanField:
        return _plan_field(read_only(field.labels.copy()), field, target)

    def _vectors(
        self, search: Search, target: PathEnd, field: WaveFrontField
    ) -> Tuple[Optional[np.ndarray], Optional[np.ndarray]]:
        values, tracer, field = search.values, self._tracer, _to_goal(field, target)
        return (
            tracer.vertex_directions(field) if values["publish_vector_field"] else None,
            tracer.face_directions(field) if values["publish_face_vectors"] else None,
        )


def _edge_solver(geometry: MeshGeometry) -> DijkstraSolver:
    return DijkstraSolver(topology=geometry.topology, edge_lengths=geometry.edge_lengths)


class CVPMeshPlanner(WaveFrontPlanner):
    """The same with lengths alone, as the released planner of this name has it."""

    parameters = PARAMETERS + (STEP_WIDTH, _cost_factor(0.0))


def _to_goal(field: WaveFrontField, target: PathEnd) -> Any:
    """A field that ends at the goal, also where it came from corners of a face it did not cross."""
    return field if target.whole else _plan_field(field.labels, field, target)


def _plan_field(labels: np.ndarray, field: WaveFrontField, target: PathEnd) -> PlanField:
    return PlanField(labels, field.limit, field.slowness, target.face_point.face, target.position)


def _seeds(target: PathEnd, slowness: Optional[np.ndarray]) -> List[Tuple[int, float]]:
    """Where the front begins if it must not cross the goal's face: vertices, and times to it."""
    if slowness is None:
        return target.corner_paths
    return [
        (vertex, distance * float(slowness[vertex])) for vertex, distance in target.corner_paths
    ]
