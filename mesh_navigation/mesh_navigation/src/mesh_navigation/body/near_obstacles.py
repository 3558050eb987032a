"""What is lethal or unknown near the robot, as points, and how near a way leads to them."""

from typing import NamedTuple, Optional

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry

TOLERANCE = 0.01  # m by which a way may be nearer than it has to keep: the wheels are not exact
_SPACING = 0.1  # m, of the points on edges between two lethal vertices
_STEP = 0.05  # m, of the places of a way that are looked at
_RISE = 1e-3  # m nearer that is no nearer


class NearObstacles(NamedTuple):
    """Those around one place, at one moment."""

    points: np.ndarray
    """(P,3) m: lethal and unknown vertices beside others, and points on the edges between them."""
    keep: float
    """m that ways have to keep from them."""

    def keeping(self, distance: float) -> "NearObstacles":
        """The same, with another distance to keep (m)."""
        return self._replace(keep=distance)

    def distances(self, places: np.ndarray) -> np.ndarray:
        """(N,) m, of places (N,3) from the nearest one; inf where there is none."""
        if not len(self.points):
            return np.full(len(places), np.inf)
        offsets = places[:, None] - self.points
        return np.sqrt(np.einsum("npi,npi->np", offsets, offsets).min(axis=1))

    def first_near(self, points: np.ndarray) -> Optional[float]:
        """How far it is along a way to where it leads too near (m); None: nowhere.

        A way that begins too near may leave, but must not lead nearer.

        Args:
            points: (N,3) m, N at least 1.
        """
        if not len(self.points):
            return None
        travelled = np.append(0.0, np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum())
        lengths = np.linspace(0.0, travelled[-1], int(travelled[-1] / _STEP) + 2)
        columns = (np.interp(lengths, travelled, points[:, axis]) for axis in range(3))
        worse = rises(self.keep - self.distances(np.stack(list(columns), axis=1)))
        return None if worse is None else float(lengths[worse])


NO_OBSTACLES = NearObstacles(np.zeros((0, 3)), 0.0)


def rises(depths: np.ndarray) -> Optional[int]:
    """The first of depths (N,) (m) within what is to be kept that is above all those before it, and
    not within the tolerance; None: there is none."""
    allowed = np.maximum(np.minimum.accumulate(depths) + _RISE, TOLERANCE)
    worse = np.flatnonzero(depths > allowed)
    return int(worse[0]) if len(worse) else None


def obstacle_points(
    geometry: MeshGeometry, blocked: np.ndarray, place: np.ndarray, reach: float
) -> np.ndarray:
    """(P,3) m: the rim of what is blocked around a place.

    Args:
        geometry: of the map.
        blocked: (V,) bool: lethal or unknown.
        place: (3,) m.
        reach: m, along each axis.
    """
    near = np.flatnonzero(blocked)
    near = near[(np.abs(geometry.vertices[near] - place) <= reach).all(axis=1)]
    topology = geometry.topology
    places = topology.neighbor_places(near)
    counts = np.diff(topology.neighbor_offsets.astype(np.int64))[near] if len(near) else near
    begins, ends = np.repeat(near, counts), topology.neighbors[places].astype(np.int64)
    is_rim = np.zeros(len(blocked), np.bool_)
    is_rim[begins[~blocked[ends]]] = True
    along = is_rim[begins] & is_rim[ends] & (begins < ends)
    vertices = geometry.vertices
    points = [vertices[near[is_rim[near]]].astype(np.float64)]
    sides = vertices[begins[along]].astype(np.float64), vertices[ends[along]].astype(np.float64)
    pieces = np.ceil(np.linalg.norm(sides[1] - sides[0], axis=1) / _SPACING).astype(np.int64)
    for count in np.unique(pieces[pieces > 1]):
        begin, end = (side[pieces == count] for side in sides)
        shares = (np.arange(1, count) / count)[:, None, None]
        points.append((begin + shares * (end - begin)).reshape(-1, 3))
    return np.concatenate(points)
