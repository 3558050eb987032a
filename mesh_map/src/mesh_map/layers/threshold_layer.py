"""Layers that measure something at each vertex and call what is above a threshold lethal.

Borders, off which a robot may fall; steepness, where it slides or topples; height differences that
it cannot climb; roughness, which shakes it; ridges, where the surface bends.
"""

import abc
import math
from typing import Any, ClassVar, Dict, List, Mapping, Optional, Tuple

import numpy as np

from mesh_map import _kernels
from mesh_map.base.parameter import Parameter, Value
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.costs.lethal_rule import LethalRule
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap


class ThresholdLayer(Layer):
    """Base of such a layer, which depends on the geometry alone. It has a parameter "threshold"."""

    @abc.abstractmethod
    def compute_costs(self, mesh_map: MeshMap) -> np.ndarray:
        """(V,) float32."""

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        return self._with_lethal(self.compute_costs(mesh_map))

    def reuse(self, costs: np.ndarray, mesh_map: MeshMap, inputs: Inputs) -> Optional[LayerResult]:
        return self._with_lethal(costs)

    def lethal_rule(self) -> LethalRule:
        return LethalRule(float(self.params["threshold"]))

    def _with_lethal(self, costs: np.ndarray) -> LayerResult:
        return LayerResult(costs, self.lethal_rule().of(costs))


class RadiusLayer(ThresholdLayer):
    """Base of one that measures what is around each vertex. It has a parameter "radius" too.

    Layers of the same radius share one pass over the mesh. Where there is a parameter
    "include_vertex", it says whether the vertex itself counts, and where there is "large_faces",
    whether the surface of faces with sides longer than the radius does.
    """

    STATISTIC: ClassVar[str]  # the method of RadiusPass that gives the costs

    @property
    def _statistic(self) -> str:
        surface = "surface_" if self.params.get("large_faces", False) else ""
        around = "" if self.params.get("include_vertex", True) else "_around"
        return surface + self.STATISTIC + around

    def announce(self, geometry: MeshGeometry) -> None:
        geometry.radius_pass(self.params["radius"]).request(self._statistic)

    def compute_costs(self, mesh_map: MeshMap) -> np.ndarray:
        radius_pass = mesh_map.geometry.radius_pass(self.params["radius"])
        return getattr(radius_pass, self._statistic)()


class BorderLayer(ThresholdLayer):
    """The border cost at vertices on an edge of only one face, else 0."""

    RELEASED_NAME = "border"
    PARAMETERS = (
        Parameter("threshold", 0.5, 0.05, 1.0, "lethal above", affects_costs=False),
        Parameter("border_cost", 1.0, 0.02, 10.0, "cost of vertices on a border"),
    )

    def largest_cost(self, geometry: MeshGeometry) -> float:
        return float(self.PARAMETERS[1].maximum)

    def compute_costs(self, mesh_map: MeshMap) -> np.ndarray:
        topology = mesh_map.topology
        costs = np.zeros(topology.vertex_count, np.float32)
        costs[topology.edges[topology.border_edges]] = self.params["border_cost"]
        return costs


class SteepnessLayer(ThresholdLayer):
    """The angle between the normal of a vertex and the up direction, in radians, 0 to pi.

    arccos(normal . up), as the SteepnessLayer of the released mesh_map.

    A map whose faces point down is steep everywhere, as in the released mesh_map, unless the map is
    told to orient them, or that down is up.
    """

    UNIT = "rad"
    RELEASED_NAME = "steepness"
    PARAMETERS = (
        Parameter("threshold", 0.3, 0.01, 3.1415, "lethal above, in radians", affects_costs=False),
    )

    def largest_cost(self, geometry: MeshGeometry) -> float:
        return math.pi

    def compute_costs(self, mesh_map: MeshMap) -> np.ndarray:
        return _kernels._angles_to(mesh_map.vertex_normals, mesh_map.geometry.up)


class HeightDiffLayer(RadiusLayer):
    """Largest minus smallest height, in meters, over a vertex and those around it within a radius.

    One of the layers of Pütz et al., 4.2 and 5.3 (height differences).

    "Around" means: reached over edges through vertices whose Euclidean distance from the vertex is
    below the radius. The vertex itself counts, unless include_vertex is false: then one without
    others around is unknown (NaN). In the released mesh_map it did not count, and such a vertex had
    -inf; in that of ROS 2 (lvr2 25) it does.

    Of a face with a side longer than the radius, at one of these vertices, the surface counts as
    far as it is within the radius, unless large_faces is false, as in the released mesh_map: there,
    a step of one row of such faces is level ground.

    From its edge, an upright step rises by no more than the radius within the radius: one that is
    not above the threshold, of which it warns, leaves steps free that have no vertex in between.
    """

    UNIT = "m"
    PARAMETERS = (
        Parameter("threshold", 0.185, 0.05, 1.0, "lethal above, in meters", affects_costs=False),
        Parameter("radius", 0.3, 0.02, 1.0, "radius of the neighborhood in meters"),
        Parameter("include_vertex", True, description="the vertex itself counts, too"),
        Parameter(
            "large_faces",
            True,
            description="the surface of faces with a side longer than the radius counts, too",
        ),
    )
    STATISTIC = "height_difference"
    RELEASED_NAME = "height_diff"

    def _checked(self, given: Mapping[str, Any]) -> Tuple[Dict[str, Value], List[str]]:
        params, warnings = super()._checked(given)
        if params["enabled"] and not _reaches(params):
            text = "radius, %s m, is not above threshold, %s m: an upright step may not be seen"
            warnings.append(text % (params["radius"], params["threshold"]))
        return params, warnings

    def sees_steps(self) -> bool:
        return bool(self.params["large_faces"]) and _reaches(self.params)

    def largest_cost(self, geometry: MeshGeometry) -> float:
        """The size of the mesh: any way may be up in the program that stored it."""
        return float(np.linalg.norm(np.ptp(geometry.vertices.astype(np.float64), axis=0)))


def _reaches(params: Mapping[str, Any]) -> bool:
    """Whether an upright step rises by more than the threshold within the radius."""
    return bool(params["radius"] > params["threshold"])


class RoughnessLayer(RadiusLayer):
    """How much the normals of neighbors differ, in radians, around each vertex within a radius.

    One of the layers of Pütz et al., 4.2 and 5.3 (roughness).

    The mean, over the vertices around it (as of height differences), of the mean angle between the
    normal of a vertex and those of its neighbors; 0 where there are none. The vertex itself counts
    where include_vertex is true, as in the release for ROS 2 (lvr2 25); in the released mesh_map it
    does not, and a non-manifold vertex has the angle pi there, whatever is around it.
    """

    UNIT = "rad"
    PARAMETERS = (
        Parameter("threshold", 0.3, 0.01, 3.1415, "lethal above, in radians", affects_costs=False),
        Parameter("radius", 0.3, 0.02, 1.0, "radius of the neighborhood in meters"),
        Parameter("include_vertex", False, description="the vertex itself counts, too"),
    )
    STATISTIC = "roughness"
    RELEASED_NAME = "roughness"

    def largest_cost(self, geometry: MeshGeometry) -> float:
        return math.pi


class RidgeLayer(RadiusLayer):
    """Mean distance, in meters, between the tips of the normals around a vertex and its own.

    As the RidgeLayer of the released mesh_map.

    The tip of a vertex is its position plus its normal of length 1. The mean is over the other
    vertices around (as of height differences) within a radius: on flat ground it is the mean
    distance of these, and larger where normals diverge. 0 where there are none; in the released
    mesh_map, such a vertex was lethal whatever the threshold.
    """

    UNIT = "m"
    PARAMETERS = (
        Parameter("threshold", 0.3, 0.01, 3.1415, "lethal above, in meters", affects_costs=False),
        Parameter("radius", 0.3, 0.01, 1.0, "radius of the neighborhood in meters"),
    )
    STATISTIC = "ridge"
    RELEASED_NAME = "ridge"
