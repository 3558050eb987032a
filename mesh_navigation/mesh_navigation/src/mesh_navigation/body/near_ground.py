"""How far the ground around one place is from what is lethal, along the surface."""

from typing import NamedTuple, Optional

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.spatial.hits import NO_FACE

from mesh_navigation.body.closed_ground import CLOSED, ClosedGround

_MARGIN = 0.5  # m farther than asked for: the next places are asked for soon


class _Found(NamedTuple):
    """For costs, within `reach` of `place`."""

    costs: np.ndarray
    place: np.ndarray
    reach: float
    vertices: np.ndarray


class NearGround:
    """What `ClosedGround` leaves open, of the part of a map that is around a place: for who cannot
    wait until a whole map has followed a change of costs. From any thread."""

    def __init__(self, geometry: MeshGeometry, radius: float) -> None:
        """
        Args:
            geometry: of the map.
            radius: of the robot (m).
        """
        self._geometry, self._radius = geometry, radius
        self._found: Optional[_Found] = None

    def open_vertices(self, costs: np.ndarray, place: np.ndarray, reach: float) -> np.ndarray:
        """(K,) ascending: on them, on edges and on faces between them, the robot's middle keeps the
        radius from what is lethal or unknown.

        Args:
            costs: (V,) of the map.
            place: (3,) m.
            reach: m from there, where no corner of a face is left out.
        """
        found = self._found
        if (
            found is None
            or found.costs is not costs
            or float(np.linalg.norm(found.place - place)) + reach > found.reach
        ):
            place, reach = np.array(place, np.float64), reach + _MARGIN
            found = _Found(costs, place, reach, self._open(costs, place, reach))
            self._found = found
        return found.vertices

    def least_distances(
        self,
        costs: np.ndarray,
        place: np.ndarray,
        reach: float,
        points: np.ndarray,
        faces: np.ndarray,
    ) -> np.ndarray:
        """(N,) m: so far, at least, points of faces are along the surface from what is lethal or
        unknown: the radius, less how far they are from what of their face is open; -inf where
        nothing is.

        Args:
            costs, place, reach: as for `open_vertices`.
            points: (N,3) m, within the reach.
            faces: (N,) in which they lie; NO_FACE where there is none.
        """
        numbers = self._geometry.faces.take(faces, axis=0, mode="clip")
        is_open = np.isin(numbers, self.open_vertices(costs, place, reach))
        is_open &= (faces != NO_FACE)[:, None]
        corners = self._geometry.vertices[numbers].astype(np.float64)
        gaps = np.full(len(points), np.inf)
        for first, second in ((0, 1), (1, 2), (2, 0)):
            begin, along = corners[:, first], corners[:, second] - corners[:, first]
            offsets = points - begin
            squares = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
            shares = np.clip(np.einsum("ij,ij->i", offsets, along) / squares, 0.0, 1.0)
            # Of an edge with one open end, that end.
            shares = np.where(is_open[:, first] & is_open[:, second], shares, 0.0)
            gap = np.linalg.norm(offsets - shares[:, None] * along, axis=1)
            gaps = np.where(is_open[:, first], np.minimum(gaps, gap), gaps)
        gaps[is_open.all(axis=1)] = 0.0
        return self._radius - gaps

    def _open(self, costs: np.ndarray, place: np.ndarray, reach: float) -> np.ndarray:
        geometry, index = self._geometry, self._geometry.spatial_index
        asked = index.in_sphere(center=place, radius=reach)
        corners = geometry.vertices[geometry.faces[asked]].astype(np.float64)
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        # What is near to a corner of these, or to an edge from it, is in this part, too.
        around = reach + 2.0 * float(sides.max(initial=0.0)) + self._radius
        faces = np.sort(index.in_sphere(center=place, radius=around))
        used, numbers = np.unique(geometry.faces[faces], return_inverse=True)
        part = MeshGeometry(geometry.vertices[used], numbers.reshape(-1, 3).astype(np.uint32))
        least = ClosedGround(part, self._radius).costs(np.ascontiguousarray(costs[used]))
        with np.errstate(invalid="ignore"):
            is_open = least < CLOSED
        return used[is_open & np.isin(used, geometry.faces[asked])]
