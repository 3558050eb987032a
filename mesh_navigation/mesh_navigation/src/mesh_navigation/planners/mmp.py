"""Locally shortest paths: exact geodesics."""

from typing import Any, Mapping

from mesh_map.base.parameter import Parameter
from mesh_map.distance.surface_path import SurfacePath
from mesh_map.distance.wave_front import WaveFrontField

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

    def _factor(self, values: Mapping[str, Any]) -> float:
        return 0.0

    def _surface_path(
        self, search: Search, origin: PathEnd, target: PathEnd, field: WaveFrontField
    ) -> SurfacePath:
        traced = super()._surface_path(search, origin, target, field)
        return self._tightened(search, origin, target, traced, _SUSPECT)
