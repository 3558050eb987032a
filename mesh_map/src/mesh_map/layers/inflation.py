"""Inflation: costs around whatever other layers call lethal."""

import math
from typing import Optional, Tuple

import numpy as np

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.costs.lethal_rule import LethalRule
from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap

_CHANGED_SHARE = 0.2  # of all vertices, above which the costs of all follow from distances again


class _Inflated:
    """Distances, and the costs and vectors that follow from them, of one lethal mask."""

    def __init__(self, geometry: MeshGeometry, radius: float) -> None:
        self.geometry = geometry
        self.radius = radius
        limit = np.nextafter(np.float32(radius), np.float32(np.inf))
        front = SurfaceFront.of(geometry)
        self.obstacles = ObstacleDistance(front=front, max_distance=float(limit))
        self.lethal: Optional[np.ndarray] = None
        self.fading: Tuple[float, ...] = ()
        self.repulsive = False
        self.costs: Optional[np.ndarray] = None
        self.vectors: Optional[np.ndarray] = None

    def compute(self, lethal: np.ndarray, fading: Tuple[float, ...], repulsive: bool) -> None:
        if self.lethal is None:
            self.obstacles.compute(lethal)
        else:
            self.obstacles.update(lethal)
        self.lethal, self.fading, self.repulsive = lethal, fading, repulsive
        self._fade()

    def _fade(self) -> None:
        kernel = _kernels._Fading(*self.fading)
        distances = self.obstacles.distances()
        self.costs = read_only(_kernels._fading_costs(distances, kernel))
        self.vectors = None
        if self.repulsive:
            self.vectors = read_only(self.obstacles.kernel._repulsion(kernel))

    def update(self, lethal: np.ndarray) -> None:
        assert self.costs is not None
        changed = self.obstacles.update(lethal)
        self.lethal = lethal
        if not len(changed):
            return
        kernel = _kernels._Fading(*self.fading)
        if len(changed) > _CHANGED_SHARE * len(lethal):
            return self._fade()
        costs = self.costs.copy()
        distances = self.obstacles.kernel._distances_of(changed)
        costs[changed] = _kernels._fading_costs(distances, kernel)
        self.costs = read_only(costs)
        if self.vectors is not None:
            vectors = self.vectors.copy()
            around = self.obstacles.kernel._with_neighbors(changed)
            vectors[around] = self.obstacles.kernel._repulsion_of(around, kernel)
            self.vectors = read_only(vectors)


class InflationLayer(Layer):
    """Costs around the lethal vertices of other layers, fading with the distance d from them.

    The inflation of Pütz et al., 4.2, by distance instead of by rings of triangles. d is measured
    along the surface from lethal vertices, edges between two of them and faces between three (see
    mesh_map.distance.obstacle_distance). With the radii r (inscribed) and R (inflation):

    * lethal vertices stay lethal, and cost lethal_value (below 0: infinite; in the combination of a
      map lethal vertices are infinite anyway);
    * d <= r: inscribed_value;
    * r < d <= R: inscribed_value times (cos(pi (d - r) / (R - r)) + 1) / 2, or, with fading
      "exponential" (as costmap_2d's inflation layer, and ROS 2), times
      exp(-cost_scaling_factor (d - r));
    * beyond: 0. Where R is not above r, nothing fades.

    The vectors of the result, with repulsive_field, point away from obstacles along the surface;
    their length is the cost in parts of inscribed_value, and 1 on lethal vertices.

    The released mesh_map faded with the square root of d, took sin for its square in the front,
    and hardly inflated lethal vertices that stand alone.
    """

    PARAMETERS = (
        Parameter("inscribed_radius", 0.25, 0.01, 5.0, "meters from obstacles at full cost"),
        Parameter("inflation_radius", 0.4, 0.01, 10.0, "meters from obstacles at any cost"),
        Parameter("lethal_value", 2.0, -1.0, math.inf, "cost of lethal vertices; -1 for infinite"),
        Parameter("inscribed_value", 1.0, 0.0, 100000.0, "cost within the inscribed radius"),
        Parameter("repulsive_field", True, description="vectors away from obstacles"),
        Parameter(
            "fading",
            "cosine",
            description="between the radii: cosine, or exponential as in ROS 2",
            choices=("cosine", "exponential"),
        ),
        Parameter("cost_scaling_factor", 1.0, 0.0, 5.0, "of exponential fading, in 1/m"),
        Parameter(
            "min_contour_size",
            3,
            0,
            100000,
            "accepted without effect, as ever",
            affects_costs=False,
        ),
        Parameter(
            "layer_factor", 1.0, 0.0, 1.0, "accepted without effect, as ever", affects_costs=False
        ),
    )
    READS_LAYERS = True
    READS_WEIGHTS = False

    _inflated: Optional[_Inflated] = None

    def lethal_rule(self) -> Optional[LethalRule]:
        value = float(self.params["lethal_value"])
        return LethalRule(value, inclusive=True) if value >= 0.0 else None

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        lethal = _lethal(mesh_map, inputs)
        fading = self._fading()
        radius = max(fading[:2])
        state, self._inflated = self._inflated, None  # what fails leaves nothing half done
        if state is None or (state.geometry, state.radius) != (mesh_map.geometry, radius):
            state = _Inflated(mesh_map.geometry, radius)
        state.compute(lethal, fading, bool(self.params["repulsive_field"]))
        return self._result(state)

    def update(
        self, mesh_map: MeshMap, inputs: Inputs, changed: np.ndarray, before: LayerResult
    ) -> LayerResult:
        """Local: the state says itself what has become lethal or ceased to be."""
        state = self._inflated
        repulsive = bool(self.params["repulsive_field"])
        if (
            state is None
            or state.geometry is not mesh_map.geometry
            or (state.fading, state.repulsive) != (self._fading(), repulsive)
        ):
            return self.compute(mesh_map, inputs)
        self._inflated = None
        state.update(_lethal(mesh_map, inputs))
        return self._result(state)

    def reuse(self, costs: np.ndarray, mesh_map: MeshMap, inputs: Inputs) -> Optional[LayerResult]:
        """The inputs say which vertices are lethal; vectors are not stored with costs.

        Nothing is computed then: distances are when an input changes for the first time.
        """
        if self.params["repulsive_field"]:
            result = self.result
            return result if result is not None and result.costs is costs else None
        return LayerResult(costs, _lethal(mesh_map, inputs))

    def _result(self, state: _Inflated) -> LayerResult:
        assert state.costs is not None and state.lethal is not None
        self._inflated = state
        return LayerResult(state.costs, state.lethal, state.vectors)

    def _fading(self) -> Tuple[float, ...]:
        """The arguments of _kernels._Fading."""
        value = self.params
        lethal_value = float(value["lethal_value"])
        return (
            float(value["inscribed_radius"]),
            float(value["inflation_radius"]),
            lethal_value if lethal_value >= 0 else math.inf,
            float(value["inscribed_value"]),
            value["fading"] == "exponential",
            float(value["cost_scaling_factor"]),
        )


def _lethal(mesh_map: MeshMap, inputs: Inputs) -> np.ndarray:
    """(V,) bool, read-only: what is lethal in any of the inputs."""
    lethal = np.zeros(len(mesh_map.vertices), np.bool_)
    for layer_input in inputs.values():
        lethal |= layer_input.lethal
    return read_only(lethal)
