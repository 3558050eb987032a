"""What is lethal or unknown near the robot, as points, and how near a way leads to them."""

from typing import Callable, NamedTuple, Optional

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry

TOLERANCE = 0.01  # m by which a way may be nearer than it has to keep: the wheels are not exact
_SPACING = 0.1  # m, of the points on edges between two lethal vertices
_STEP = 0.05  # m, of the places of a way that are looked at
_RISE = 1e-3  # m nearer that is no nearer


def _unknown(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    return np.full(len(points), -np.inf)


class NearObstacles(NamedTuple):
    """Those around one place, at one moment.

    Distances from points are straight ones. Along the surface it may be farther, as over rough
    ground, or there is no way at all, as to a thing so low that the robot drives over it. Ways are
    as near as they are along the surface, which is what planners keep.
    """

    points: np.ndarray
    """(P,3) m: lethal and unknown vertices beside others, and points on the edges between them."""
    keep: float
    """m that ways have to keep from them."""
    nearer: float = TOLERANCE
    """m by which ways may be nearer than that."""
    radius: float = 0.0
    """m, of the robot."""
    least: Callable[[np.ndarray, np.ndarray], np.ndarray] = _unknown
    """How far (N,) points (N,3) of faces (N,) are at least, along the surface, up to the radius."""

    def keeping(self, distance: float) -> "NearObstacles":
        """The same, with another distance to keep (m)."""
        return self._replace(keep=distance)

    def left_from(self, place: np.ndarray) -> "NearObstacles":
        """The same, but ways may be as near, or nearly, as a place (3,) (m) is: where one leads out
        of ground that is too near."""
        depth = self.keep - float(self.distances(place[None])[0])
        return self._replace(nearer=max(depth, 0.0) + TOLERANCE)

    def distances(self, places: np.ndarray) -> np.ndarray:
        """(N,) m, of places (N,3) from the nearest one; inf where there is none."""
        if not len(self.points):
            return np.full(len(places), np.inf)
        offsets = places[:, None] - self.points
        return np.sqrt(np.einsum("npi,npi->np", offsets, offsets).min(axis=1))

    def _within(self, low: np.ndarray, high: np.ndarray) -> "NearObstacles":
        return self._replace(
            points=self.points[((self.points >= low) & (self.points <= high)).all(axis=1)]
        )

    def first_near(self, points: np.ndarray, faces: np.ndarray) -> Optional[float]:
        """How far it is along a way to where it leads too near (m); None: nowhere.

        A way that begins too near may leave, but must not lead nearer.

        Args:
            points: (N,3) m, N at least 1.
            faces: (N - 1,) the face in which point i to i + 1 lies; NO_FACE where there is none.
        """
        if not len(self.points):
            return None
        near = self._within(points.min(axis=0) - self.keep, points.max(axis=0) + self.keep)
        if not len(near.points):
            return None
        sides = np.sqrt(np.square(points[1:] - points[:-1]).sum(axis=1))
        travelled = np.append(0.0, sides.cumsum())
        last = int(travelled[-1] / _STEP) + 1
        lengths = np.arange(last + 1) * (travelled[-1] / last)
        lengths[-1] = travelled[-1]
        places = np.zeros((len(lengths), 3))
        for axis in range(3):
            places[:, axis] = np.interp(lengths, travelled, points[:, axis])
        distances = near.distances(places)
        worse = rises(self.keep - distances, self.nearer)
        if worse is not None and len(faces) and distances.min() < self.radius:
            segments = np.clip(travelled.searchsorted(lengths) - 1, 0, len(faces) - 1)
            distances = np.maximum(distances, self.least(places, faces[segments]))
            worse = rises(self.keep - distances, self.nearer)
        return None if worse is None else float(lengths[worse])


NO_OBSTACLES = NearObstacles(np.zeros((0, 3)), 0.0)


def rises(depths: np.ndarray, tolerance: float = TOLERANCE) -> Optional[int]:
    """The first of depths (N,) (m) within what is to be kept that is above all those before it, and
    not within the tolerance (m); None: there is none."""
    allowed = np.maximum(np.minimum.accumulate(depths) + _RISE, tolerance)
    worse = np.flatnonzero(depths > allowed)
    return int(worse[0]) if len(worse) else None


def obstacle_points(
    geometry: MeshGeometry, costs: np.ndarray, place: np.ndarray, reach: float
) -> np.ndarray:
    """(P,3) m: the rim of what is lethal or unknown around a place.

    Args:
        geometry: of the map.
        costs: (V,) of the map.
        place: (3,) m.
        reach: m, of the faces whose corners are looked at; some of these are farther.
    """
    topology, vertices = geometry.topology, geometry.vertices
    corners = geometry.faces[geometry.spatial_index.in_sphere(center=place, radius=reach)].ravel()
    near = np.unique(corners[~np.isfinite(costs[corners])])
    if not len(near):
        return np.zeros((0, 3))
    ends = topology.neighbors[topology.neighbor_places(near)].astype(np.int64)
    offsets = topology.neighbor_offsets
    of_near = np.repeat(np.arange(len(near)), (offsets[near + 1] - offsets[near]).astype(np.int64))
    is_rim = np.zeros(len(near), np.bool_)
    is_rim[of_near[np.isfinite(costs[ends])]] = True
    rim, begins = near[is_rim], near[of_near]
    others = near.searchsorted(ends)  # isin() would sort all of them
    is_known = near.take(others, mode="clip") == ends
    along = is_rim[of_near] & is_known & is_rim.take(others, mode="clip") & (begins < ends)
    points = [vertices[rim].astype(np.float64)]
    sides = vertices[begins[along]].astype(np.float64), vertices[ends[along]].astype(np.float64)
    pieces = np.ceil(np.linalg.norm(sides[1] - sides[0], axis=1) / _SPACING).astype(np.int64)
    for count in np.unique(pieces[pieces > 1]):
        begin, end = (side[pieces == count] for side in sides)
        shares = (np.arange(1, count) / count)[:, None, None]
        points.append((begin + shares * (end - begin)).reshape(-1, 3))
    return np.concatenate(points)
