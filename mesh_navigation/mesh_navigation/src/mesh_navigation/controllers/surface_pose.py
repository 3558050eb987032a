"""Where on the surface the robot stands, also where there are several storeys."""

import math
from typing import Any, NamedTuple, Optional

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.walk import WalkEnd
from mesh_map.geometry.walk_start import walk_start
from mesh_map.map.queries import SurfaceQueries

from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import Pose, number_text, rotate, vector_text
from mesh_navigation.controllers.vector3 import (
    Vector3,
    along_plane,
    cross,
    dot,
    minus,
    unit,
    vector3,
)
from mesh_navigation.plugins.controller import ControlFailure

MAX_STEPS = 100_000  # faces of one walk
SAME_SHEET = 0.02  # m from where a walk ends to the place that it looked for
_STEEP = 0.5  # cosine of the slope from where on the surface counts as a wall
_FLAT = 1e-3  # of a vector of length 1 in a plane: less is no direction
_X, _Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


class SurfacePose(NamedTuple):
    """The robot on the surface; a start for walks and for ways down a field."""

    face: int
    position: np.ndarray
    """(3,) m, the point of the surface that carries the robot."""
    barycentric: np.ndarray
    """(3,) weights of the corners of the face."""
    normal: Vector3
    """Of the face, to the side on which the robot is."""
    up: Vector3
    """From the surface to that side: vertical, but on walls the normal."""
    heading: Vector3
    """Of length 1, in the plane of the face."""

    @property
    def point(self) -> Vector3:
        """The position as a tuple."""
        return vector3(self.position)

    def direction_to(self, point: Vector3) -> Optional[Vector3]:
        """Where a straight way to a point begins, in the plane of the face; None at the point."""
        chord = minus(point, self.point)
        steepness = dot(self.up, self.normal)
        share = dot(chord, self.normal) / steepness
        along = tuple(c - share * u for c, u in zip(chord, self.up))
        return unit(along) if dot(along, along) > 1e-12 else None


class Locator:
    """Finds the surface below the robot from one cycle to the next."""

    def __init__(self, geometry: MeshGeometry) -> None:
        self._geometry = geometry
        self._queries = SurfaceQueries(geometry)
        self._up = vector3(geometry.up)

    def stand(self, pose: Pose, hint: Any, distance: float, radius: float) -> SurfacePose:
        """Where a pose stands.

        Args:
            pose: of the robot; its z axis tells on which side of the surface it is.
            hint: anything with face, position and barycentric: where it was before; None if that is
                not known. A place that can be reached from there wins over nearer ones.
            distance: from the surface that is allowed (m).
            radius: from the hint; farther away the robot was put there by someone (m).

        Raises:
            ControlFailure: OUT_OF_MAP, no surface; NO_VALID_CMD, it looks straight up or down.
        """
        near = self._queries.carrying_face(pose.position, max_distance=distance)
        if near is None:
            raise ControlFailure(ExePathOutcome.OUT_OF_MAP, self._off_map(pose, distance))
        up = vector3(rotate(pose.orientation, _Z))
        place = near
        if hint is not None and math.dist(hint.position, near.position) <= distance + radius:
            place = self._same_sheet(pose.position, near, hint, up, distance)
        return self._surface_pose(place, pose, up)

    def _same_sheet(
        self, position: np.ndarray, near: Any, hint: Any, up: Vector3, distance: float
    ) -> Any:
        """The nearest place, or that on the sheet of the hint if they are on different ones."""
        up = self._outwards(self.normal(hint.face), up)[1]
        walker = self._geometry.walker
        for target, allowed in ((near.position, SAME_SHEET), (position, distance)):
            walk = walker.line(start=hint, target=target, up=up, max_steps=MAX_STEPS)
            missed = math.dist(walk.position, target)
            if walk.end == WalkEnd.ARRIVED and missed <= allowed:
                is_near = target is near.position and self._part(walk) == self._part(near)
                return near if is_near else walk
        return near

    def _part(self, place: Any) -> int:
        """The connected part of the mesh: that of the bottom of a thing is not that of the floor on
        which it stands."""
        return int(self._geometry.topology.components[self._geometry.faces[place.face, 0]])

    def _surface_pose(self, place: Any, pose: Pose, z_axis: Vector3) -> SurfacePose:
        ahead = vector3(rotate(pose.orientation, _X))
        place = walk_start(self._geometry, place, ahead, z_axis)
        normal, up = self._outwards(self.normal(place.face), z_axis)
        flat = along_plane(ahead, normal)
        if dot(flat, flat) < _FLAT * _FLAT:
            raise ControlFailure(
                ExePathOutcome.NO_VALID_CMD,
                f"the robot at {vector_text(pose.position)} has no heading: its x axis "
                f"{vector_text(pose.heading)} is upright on the surface",
            )
        heading = unit(flat)
        return SurfacePose(int(place.face), place.position, place.barycentric, normal, up, heading)

    def _outwards(self, normal: Vector3, z_axis: Vector3) -> Any:
        """Normal and up on the side of the robot."""
        if dot(normal, z_axis) < 0.0:
            normal = (-normal[0], -normal[1], -normal[2])
        steepness = dot(normal, self._up)
        if abs(steepness) < _STEEP:
            return normal, normal
        sign = 1.0 if steepness > 0.0 else -1.0
        return normal, tuple(sign * u for u in self._up)

    def normal(self, face: int) -> Vector3:
        """Of a face, of length 1, as it is wound."""
        a, b, c = self._geometry.vertices[self._geometry.faces[face]].tolist()
        return unit(cross(minus(b, a), minus(c, a))) or self._up

    def _off_map(self, pose: Pose, distance: float) -> str:
        where = f"the robot at {vector_text(pose.position)} is"
        nearest = self._queries.carrying_face(pose.position, max_distance=np.inf)
        if nearest is None:
            return f"{where} too far from the map to tell how far"
        return (
            f"{where} {number_text(nearest.distance)} m from the map, allowed are {distance:.2f} m "
            f"(max_search_distance); the surface is nearest at {vector_text(nearest.position)}"
        )
