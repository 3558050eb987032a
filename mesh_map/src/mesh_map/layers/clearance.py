"""Clearance: where the robot does not fit under what is above."""

from typing import Optional

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.costs.lethal_rule import LethalRule
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.spatial_index import SpatialIndex

_LEAST_LIFT = 1e-3  # meters
_BELOW_ONE = np.nextafter(np.float32(1), np.float32(0))


def clearances(geometry: MeshGeometry) -> np.ndarray:
    """(V,) float32: meters from each vertex along its normal to the next face.

    A face counts from behind, too; +inf where there is none. Rays begin a millimeter above the
    vertex, or four times the distance of neighboring 32-bit floats at its coordinates where that is
    more (over two kilometers from the origin): nearer faces are the surface itself. Computed once
    for a geometry, whatever number of maps and layers ask.
    """
    return geometry.made(_cast)


def _cast(geometry: MeshGeometry) -> np.ndarray:
    normals = geometry.vertex_normals.astype(np.float64)
    return free_distances(geometry.spatial_index, geometry.vertices, normals, _LEAST_LIFT)


def free_distances(
    index: SpatialIndex, vertices: np.ndarray, directions: np.ndarray, lift: float
) -> np.ndarray:
    """(V,) float32: meters from each vertex to the next face in a direction, +inf for none.

    Args:
        index: of the faces.
        vertices: (V, 3) float32 meters.
        directions: (V, 3) float64 of length 1.
        lift: meters; what is nearer is passed, and up to four times the distance of neighboring
            32-bit floats, where that is more.
    """
    lifts = np.maximum(4 * np.spacing(np.abs(vertices).max(axis=1)), lift)
    hits = index.cast_batch(
        origins=vertices + lifts[:, None].astype(np.float64) * directions, directions=directions
    )
    return read_only((hits.distances + lifts).astype(np.float32))


class ClearanceLayer(Layer):
    """1 and lethal where there is less room along the normal than the robot is high, 0 far above.

    With the clearance c of a vertex, the height of the robot h and the inflation i: 1 for c < h,
    (cos(pi (c - h) / i) + 1) / 2, but less than 1, for h <= c < h + i (the cosine with which
    InflationLayer fades), else 0, as where nothing is above. On maps whose normals point down, the
    map has to be told to orient them: this layer looks where they point.
    """

    PARAMETERS = (
        Parameter("robot_height", 0.5, 0.05, 100.0, "meters that the robot needs"),
        Parameter("height_inflation", 0.3, 0.0, 100.0, "meters above that which cost something"),
    )

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        room = clearances(mesh_map.geometry)
        height, inflation = self.params["robot_height"], self.params["height_inflation"]
        costs = np.zeros(len(room), np.float32)
        lethal = room < np.float32(height)
        if inflation > 0:
            tight = np.flatnonzero(~lethal & (room < height + inflation))
            share = (room[tight].astype(np.float64) - np.float32(height)) / inflation
            costs[tight] = np.minimum((np.cos(np.pi * share) + 1) / 2, _BELOW_ONE)
        costs[lethal] = 1.0
        return LayerResult(read_only(costs), lethal)

    def reuse(self, costs: np.ndarray, mesh_map: MeshMap, inputs: Inputs) -> Optional[LayerResult]:
        return LayerResult(costs, self.lethal_rule().of(costs))

    def lethal_rule(self) -> LethalRule:
        return LethalRule(1.0, inclusive=True)
