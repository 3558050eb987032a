"""Collisions: where the robot's body meets what stands or hangs there, or is in something solid."""

from typing import NamedTuple, Optional

import numpy as np

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only
from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.costs.lethal_rule import LethalRule
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.solids import find_solids
from mesh_map.layers.clearance import free_distances
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.spatial_index import SpatialIndex


class UprightMesh(NamedTuple):
    """A mesh turned so that up is z: (V, 3) float32 vertices, and the index of its faces."""

    vertices: np.ndarray
    index: SpatialIndex


def _upright(geometry: MeshGeometry) -> UprightMesh:
    """With vertices that count as one at one place."""
    up, vertices = geometry.up.astype(np.float64), geometry.vertices
    joined = vertices[find_solids(geometry).joined]
    if np.array_equal(joined, vertices):
        joined = vertices
    if np.array_equal(up, (0.0, 0.0, 1.0)):
        if joined is vertices:
            return UprightMesh(vertices, geometry.spatial_index)
        return UprightMesh(joined, SpatialIndex(joined, geometry.faces))
    across = np.eye(3)[np.argmin(np.abs(up))]
    across -= (across @ up) * up
    across /= np.linalg.norm(across)
    turn = np.stack([across, np.cross(up, across), up])  # exact where up is an axis
    vertices = np.ascontiguousarray(joined.astype(np.float64) @ turn.T, np.float32)
    return UprightMesh(vertices, SpatialIndex(vertices, geometry.faces))


def collisions(
    geometry: MeshGeometry, *, robot_radius: float, step_height: float, robot_height: float
) -> np.ndarray:
    """(V,) bool: where a body that stands at a vertex meets a face, or is in something solid.

    See CollisionLayer.

    Args:
        robot_radius, step_height, robot_height: meters, 0 or more.
    Raises:
        MeshMapError: a step_height that is not below robot_height.
    """
    if not step_height < robot_height:
        raise MeshMapError(
            "step_height (%g m) has to be below robot_height (%g m)" % (step_height, robot_height)
        )
    upright, solids = geometry.made(_upright), find_solids(geometry)
    up = np.broadcast_to(np.float64([0, 0, 1]), upright.vertices.shape)
    rooms = free_distances(upright.index, upright.vertices, up, step_height)
    met = _kernels._collisions(
        upright.index.native,
        upright.vertices,
        solids.faces,
        solids.vertex_face_offsets,
        solids.vertex_faces,
        solids.numbers,
        rooms,
        robot_radius,
        step_height,
        robot_height,
        0,
        None,
    )
    return met.view(np.bool_)[solids.joined]


class CollisionLayer(Layer):
    """1 and lethal where a body on the floor meets a face of whatever part, or is in a solid; 0.

    "Collision" is the word of MoveIt, FCL and OMPL for a state in which the body meets something.

    The body stands upright (along the up direction): it is what is between step_height and
    robot_height above the ground, within robot_radius. A vertex stands for its cell: what is nearer
    to it than to the other corners of its faces. It is lethal where

    * a face is above any point of its cell, between step_height and robot_height above that point:
      so a wall as thin as one sheet leaves no gap, however large the faces of the floor are;
    * the body is in a solid: in a closed surface (see mesh_map.geometry.solids), or between an
      outer and an inner one. What no body between step_height and robot_height meets, because it is
      lower, can be driven over;
    * with a robot_radius, a face is within it, between step_height and robot_height above the
      vertex, and is no ground. Ground is what is reached from the vertex within the radius over
      slopes of up to 45 degrees and steps of up to step_height.

    Up to 0.1 mm (on large coordinates more) is rounding: a step exactly as high as step_height is
    climbed, and a door exactly as high as the robot is passed.
    """

    PARAMETERS = (
        Parameter(
            "robot_radius",
            0.0,
            0.0,
            5.0,
            "meters around the middle that the body needs; 0 where inflation or planners keep it",
        ),
        Parameter("step_height", 0.185, 0.01, 100.0, "meters that the robot climbs"),
        Parameter("robot_height", 0.5, 0.05, 100.0, "meters that the robot needs"),
    )

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        names = ("robot_radius", "step_height", "robot_height")
        lethal = collisions(mesh_map.geometry, **{name: self.params[name] for name in names})
        return LayerResult(read_only(lethal.astype(np.float32)), read_only(lethal))

    def reuse(self, costs: np.ndarray, mesh_map: MeshMap, inputs: Inputs) -> Optional[LayerResult]:
        return LayerResult(costs, self.lethal_rule().of(costs))

    def lethal_rule(self) -> LethalRule:
        return LethalRule(1.0, inclusive=True)
