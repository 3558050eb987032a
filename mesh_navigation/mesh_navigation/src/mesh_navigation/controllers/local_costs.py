"""Where the surface is blocked at one moment."""

import math
from typing import Iterator, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.surface import barycentric_coordinates
from mesh_map.spatial.hits import NO_FACE


# A robot that stands on blocked ground may leave it by a way this short (m): it was pushed there,
# or what was marked is next to it.
ESCAPE = 0.2


class Stretch(NamedTuple):
    """A part of a way that is blocked."""

    begin: float
    """m, along the way."""
    end: float


class LocalCosts:
    """The costs of one moment, looked at only where a way goes.

    A point is blocked where the corner with the largest weight in its face (barycentric
    coordinates) is lethal or unknown. In the face of the goal nothing is, unless the corner nearest
    to the goal is: that is how planners tell whether a goal is blocked.
    """

    def __init__(
        self, geometry: MeshGeometry, costs: np.ndarray, goal_face: int, goal: np.ndarray
    ) -> None:
        """Args:
        geometry: of the map.
        costs: (V,) of the map; what is not finite is blocked.
        goal_face: the face of the goal.
        goal: (3,) its position (m).
        """
        self._vertices, self._faces, self._costs = geometry.vertices, geometry.faces, costs
        corners = geometry.faces[goal_face]
        distances = [math.dist(corner, goal) for corner in geometry.vertices[corners].tolist()]
        free = math.isfinite(costs[corners[distances.index(min(distances))]])
        self._open_face = goal_face if free else NO_FACE

    def first_blocked(self, points: np.ndarray, faces: np.ndarray) -> Optional[float]:
        """How far it is along a way to where it is blocked (m), None if it is nowhere.

        A way that begins on blocked ground may leave it, see `ESCAPE`.

        Args:
            points: (N,3) m.
            faces: (N - 1,) the face in which point i to i + 1 lies; NO_FACE where there is none.
        """
        # take() is faster than indices in brackets; NO_FACE, which _blocked leaves out, is clipped.
        corners = self._faces.take(faces, axis=0, mode="clip")
        free = np.isfinite(self._costs.take(corners))
        if free.all():
            return None
        end_of_escape = 0.0
        for stretch in self._blocked(points, faces, free):
            if stretch.begin > end_of_escape + 1e-6:
                return stretch.begin
            end_of_escape = stretch.end
            if end_of_escape > ESCAPE:
                return 0.0
        return None

    def _blocked(
        self, points: np.ndarray, faces: np.ndarray, free: np.ndarray
    ) -> Iterator[Stretch]:
        """The stretches that are blocked, in each face by itself, in the order of the way."""
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        begins = np.cumsum(lengths) - lengths
        mixed = ~free.all(axis=1) & (faces != NO_FACE) & (faces != self._open_face)
        for index in np.flatnonzero(mixed):
            corners = self._vertices[self._faces[faces[index]]].astype(np.float64)
            weights = barycentric_coordinates(points[index : index + 2], *corners)
            parts = [_largest(weights, corner) for corner in np.flatnonzero(~free[index])]
            for begin, end in sorted(part for part in parts if part is not None):
                start, length = float(begins[index]), float(lengths[index])
                yield Stretch(start + begin * length, start + end * length)


def _largest(weights: np.ndarray, corner: int) -> Optional[Tuple[float, float]]:
    """Where between two points (0 to 1) a corner's weight is the largest; None: nowhere."""
    begin, end = 0.0, 1.0
    for other in range(3):
        if other == corner:
            continue
        first, last = weights[:, corner] - weights[:, other]
        if first < 0.0 and last < 0.0:
            return None
        if first < 0.0:
            begin = max(begin, first / (first - last))
        elif last < 0.0:
            end = min(end, first / (first - last))
    return (float(begin), float(end)) if begin < end else None
