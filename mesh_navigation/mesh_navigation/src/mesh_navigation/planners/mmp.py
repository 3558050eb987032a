"""Locally shortest paths: exact geodesics."""

from typing import Any, Mapping

import numpy as np

from mesh_map.base.parameter import Parameter
from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.distance.exact_geodesic import ExactGeodesic
from mesh_map.distance.surface_path import SurfacePath
from mesh_map.distance.wave_front import WaveFrontField

from mesh_navigation.planners.dijkstra import first_corner
from mesh_navigation.planners.path_ends import PathEnd
from mesh_navigation.planners.surface_planner import PARAMETERS, Search
from mesh_navigation.planners.wave_front import STEP_WIDTH, WaveFrontPlanner

# A geodesic that is longer than the front promised, by more than this share, may not be the best.
_SUSPECT = 1e-5

_UNUSED = "accepted, without effect: "


class MMPPlanner(WaveFrontPlanner):
    """The wave front's path, pulled taut over the faces that may be passed.

    No path near it is shorter, and it is not longer than the shortest along edges. Costs only count
    as obstacles: what is over the cost limit is not crossed. The cost is the length of the path.
    Faces need no filtering: slivers, short edges and faces without area are passed as they are.
    """

    parameters = PARAMETERS + (
        STEP_WIDTH,
        Parameter(
            "min_vertex_angle", 0.01, 0.0, 0.1, _UNUSED + "slivers (angles in rad) do no harm"
        ),
        Parameter("min_edge_length", 0.04, 0.0, 1.0, _UNUSED + "short edges (m) do no harm"),
        Parameter("export_filtered_mesh", False, description=_UNUSED + "no face is filtered out"),
    )

    def _prepare(self) -> None:
        super()._prepare()
        geometry = self.map.geometry
        self._geodesic = ExactGeodesic.of(geometry)
        self._edges = DijkstraSolver(topology=geometry.topology, edge_lengths=geometry.edge_lengths)

    def _factor(self, values: Mapping[str, Any]) -> float:
        return 0.0

    def _surface_path(
        self, search: Search, origin: PathEnd, target: PathEnd, field: WaveFrontField
    ) -> SurfacePath:
        traced = super()._surface_path(search, origin, target, field)
        path = self._taut(search, traced)
        if path.length <= (1 + _SUSPECT) * traced.potentials[0]:
            return path
        # The front promised less. What is pulled taut from the way over edges is never longer than
        # that, and may be on a better side of a hill.
        other = self._taut(search, self._along_edges(search, origin, target))
        return min(path, other, key=lambda candidate: candidate.length)

    def _taut(self, search: Search, path: SurfacePath) -> SurfacePath:
        """The locally shortest path, over what may be passed, that a path becomes."""
        return self._geodesic.shorten(path, mask=search.snapshot.open_faces, cancel=search.flag)

    def _along_edges(self, search: Search, origin: PathEnd, target: PathEnd) -> SurfacePath:
        """The shortest way over edges, as Dijkstra's algorithm finds it."""
        found = self._edges.solve(
            target.corner_paths,
            vertex_costs=search.snapshot.slowness,
            targets=origin.vertices,
            cancel_flag=search.flag,
        )
        way = found.way_from(first_corner(origin.corner_paths, found)[0])
        points = np.concatenate(
            [origin.position[None], self.map.vertices[way], target.position[None]]
        )
        faces_of = self.map.topology.faces_of
        between = [
            np.intersect1d(faces_of(a), faces_of(b))[0]
            for a, b in zip(way.tolist(), way[1:].tolist())
        ]
        faces = np.array(
            [origin.face_point.face, *between, target.face_point.face], dtype=np.uint32
        )
        return SurfacePath(points, faces, np.zeros(len(points)))
