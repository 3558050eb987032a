"""A scan laid onto a surface: point-to-plane registration (Y. Chen and G. Medioni: Object Modelling
by Registration of Multiple Range Images, 1992)."""

from typing import NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.rotation import rotated
from mesh_map.registration.rigid import inverse, motion, moved, numbers_of
from mesh_map.spatial.hits import NO_FACE, RayHits
from mesh_map.spatial.spatial_index import SpatialIndex

_ENOUGH = 30  # points; fewer say nothing about six numbers
_DONE = 3e-4, 1e-4  # m and rad; smaller steps are the last
_SHRINK = 0.6  # of the distance within which points count, from step to step
_OVER = 0.9  # of the distance to the surface, that has to be along its normal
_MOST_TURN = 0.1  # rad in a step
# Which directions the surface tells of: only rows that change by so much in a direction count for
# it (the sine of 9 degrees: the normals of a reconstructed wall scatter by less), and these have to
# be so many, or such a share of all.
_CLEAR, _LEAST_ROWS, _LEAST_SHARE = 0.15, 10.0, 0.005
_BESIDE = 5.0  # times the limit, that a ray may end before or behind the surface
_NOTHING = 1e-9  # share of the largest eigenvalue that is 0 but for rounding
CLOSEST, RAYS = "closest", "rays"


class Registration(NamedTuple):
    """Where a scan lies.

    Attributes:
        pose: (4, 4) float64, from the scan into the surface's frame.
        information: (6, 6): sums of squares of how the distances change by a small motion in the
            scan's frame (translation, rotation), 1 / m^2. None in directions that the surface does
            not tell.
        told: in how many of the six directions the surface tells where the scan is.
        count: points that lie on the surface at the end.
        share: of those within the first distance of it at the end, how many lie on it.
        residual: m, root mean square of their distances.
    """

    pose: np.ndarray
    information: np.ndarray
    told: int
    count: int
    share: float
    residual: float


class ScanRays(NamedTuple):
    """The rays of a scan, and what they meet on a surface.

    Attributes:
        directions: (N, 3) of length 1 in the surface's frame.
        ranges: (N,) m from the sensor to the points.
        hits: where each meets the surface first.
        normals: (N, 3) there; of no meaning where it meets nothing.
    """

    directions: np.ndarray
    ranges: np.ndarray
    hits: RayHits
    normals: np.ndarray


class PlaneTarget:
    """A surface that scans are laid onto, with the normals of its faces."""

    def __init__(self, index: SpatialIndex, normals: np.ndarray) -> None:
        """
        Args:
            index: of the surface.
            normals: (F, 3) of its faces, of length 1, or 0 of faces without area.
        """
        self.index, self.normals = index, normals

    @classmethod
    def of(cls, vertices: np.ndarray, faces: np.ndarray) -> "PlaneTarget":
        """Of a mesh that has no index yet.

        Args:
            vertices: (V, 3) m.
            faces: (F, 3), at least one; counter-clockwise seen from where sensors were.
        """
        a, b, c = np.moveaxis(np.asarray(vertices, np.float64)[faces], 1, 0)
        normals = np.cross(b - a, c - a)
        lengths = np.linalg.norm(normals, axis=1)
        normals /= np.where(lengths > 0, lengths, 1)[:, None]
        return cls(SpatialIndex(vertices, faces, device="off"), normals)

    def register(
        self,
        points: np.ndarray,
        pose: np.ndarray,
        *,
        origins: Optional[np.ndarray] = None,
        prior: Optional[np.ndarray] = None,
        matching: str = CLOSEST,
        max_distance: float = 0.5,
        min_distance: float = 0.1,
        steps: int = 30,
        cancel: Optional[CancelFlag] = None,
    ) -> Optional[Registration]:
        """Lay a scan onto the surface.

        Args:
            points: (N, 3) in the scan's frame, in m.
            pose: (4, 4), about where the scan lies.
            origins: (N, 3) or (3,) in the scan's frame, where the sensor was; None: at its origin.
            prior: (6, 6), how sure `pose` is: the inverse of its covariance times the variance of a
                distance; None: the points alone decide.
            matching: of which place of the surface the plane is that a point is laid onto.
                "closest": the nearest one, where the sensor saw the face from its front; "rays":
                the first one on the way from the sensor, whichever side of the face that is.
            max_distance, min_distance: m from the surface within which points count, at first and
                in the end.
            steps: at most.

        Returns:
            None where too few points are near.
        """
        points = np.asarray(points, np.float64)
        starts = np.zeros(3) if origins is None else np.asarray(origins, np.float64)
        # Rotations count as what they do to a point as far as most.
        lever = (
            max(float(np.sqrt(np.mean(np.sum(points**2, axis=1)))), 1e-3) if len(points) else 1
        )
        scale = np.array([1.0, 1.0, 1.0, lever, lever, lever])
        limit, guess = max_distance, pose
        information, told, residual = np.zeros((6, 6)), 0, np.inf
        matches = {CLOSEST: self._closest, RAYS: self._met}[matching]
        for _ in range(steps):
            near, normals, distances = matches(points, starts, pose, limit, cancel)
            if len(near) < _ENOUGH:
                return None
            # The scan moves in its own frame: n . R (t + r x p), so that the derivatives are R^T n
            # and p x R^T n.
            own = rotated(normals, pose[:3, :3].T)
            rows = np.concatenate([own, np.cross(points[near], own)], axis=1)
            # Tukey's weights, so that what lies elsewhere does not pull.
            weights = (1 - np.minimum(1, np.abs(distances) / limit) ** 2) ** 2
            right = -np.einsum("ni,n->i", weights[:, None] * rows, distances)
            information, right, told = _told(rows, weights, right, scale)
            matrix = information
            if prior is not None:
                matrix = matrix + prior
                right = right - prior @ numbers_of(inverse(guess) @ pose)
            step = _solved(matrix, right, scale)
            step *= min(1.0, limit / max(float(np.linalg.norm(step[:3])), 1e-12))
            step *= min(1.0, _MOST_TURN / max(float(np.linalg.norm(step[3:])), 1e-12))
            pose = pose @ motion(step)
            residual = float(
                np.sqrt(np.average(distances**2, weights=np.maximum(weights, 1e-12)))
            )
            small = np.linalg.norm(step[:3]) < _DONE[0] and np.linalg.norm(step[3:]) < _DONE[1]
            if small and limit <= min_distance:
                break
            limit = max(min_distance, _SHRINK * limit)
        count = len(matches(points, starts, pose, limit, cancel)[0])
        around = len(matches(points, starts, pose, max_distance, cancel)[0])
        return Registration(pose, information, told, count, count / max(1, around), residual)

    def _closest(
        self,
        points: np.ndarray,
        starts: np.ndarray,
        pose: np.ndarray,
        limit: float,
        cancel: Optional[CancelFlag],
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points over the surface, seen from its front: which, (N,); the normals there, (N, 3); the
        distances along these, (N,) m."""
        there, sensor = moved(pose, points), moved(pose, starts)
        hits = self.index.closest_batch(
            points=there, max_distance=limit, back_end="native", cancel=cancel
        )
        near = np.flatnonzero(hits.faces != NO_FACE)
        normals = self.normals[hits.faces[near]]
        distances = np.einsum("ij,ij->i", normals, there[near] - hits.positions[near])
        way = np.broadcast_to(sensor, there.shape)[near] - there[near]
        # What lies beside the surface, not over it, has no plane there.
        over = np.abs(distances) > _OVER * hits.distances[near] - 1e-3
        over &= np.einsum("ij,ij->i", normals, way) > 0
        return near[over], normals[over], distances[over]

    def _met(
        self,
        points: np.ndarray,
        starts: np.ndarray,
        pose: np.ndarray,
        limit: float,
        cancel: Optional[CancelFlag],
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As _closest, of the places that rays to the points meet first."""
        rays = self.cast(points, starts, pose, cancel)
        along = rays.ranges - rays.hits.distances  # -inf where nothing is met
        slant = np.einsum("ij,ij->i", rays.normals, rays.directions)
        with np.errstate(invalid="ignore"):
            distances = along * slant
            near = (np.abs(distances) <= limit) & (np.abs(along) <= _BESIDE * limit)
        return np.flatnonzero(near), rays.normals[near], distances[near]

    def cast(
        self,
        points: np.ndarray,
        origins: np.ndarray,
        pose: np.ndarray,
        cancel: Optional[CancelFlag] = None,
    ) -> "ScanRays":
        """The rays of a scan at a pose.

        Args:
            points: (N, 3) in the scan's frame, in m.
            origins: (N, 3) or (3,) there.
            pose: (4, 4) of the scan.
        """
        there, sensor = moved(pose, points), moved(pose, origins)
        ways = there - sensor
        ranges = np.sqrt(np.einsum("ij,ij->i", ways, ways))
        directions = ways / np.maximum(ranges, 1e-9)[:, None]
        hits = self.index.cast_batch(
            origins=sensor, directions=directions, back_end="native", cancel=cancel
        )
        normals = self.normals[np.where(hits.faces == NO_FACE, 0, hits.faces)]
        return ScanRays(directions, ranges, hits, normals)


def _told(
    rows: np.ndarray, weights: np.ndarray, right: np.ndarray, scale: np.ndarray
) -> Tuple[np.ndarray, np.ndarray, int]:
    """Normal equations without the directions of which the rows do not tell, and how many are left.

    An eigenvector of the information is a direction that is told if enough rows change clearly in
    it (T. Tuna et al.: X-ICP, Localizability-Aware LiDAR Registration, 2023): many that change a
    little are bumps of the surface, or errors of its normals.
    """
    rows = rows / scale
    information = np.einsum("ni,nj->ij", weights[:, None] * rows, rows)
    vectors = np.linalg.eigh(information)[1]
    changes = np.einsum("ni,ij->nj", rows, vectors) ** 2
    changes *= changes > _CLEAR**2
    sums = np.einsum("n,nj->j", weights, changes)
    told = vectors[:, sums >= max(_LEAST_ROWS, _LEAST_SHARE * len(rows))]
    onto = told @ told.T
    information = onto @ information @ onto * np.outer(scale, scale)
    return information, scale * (onto @ (right / scale)), told.shape[1]


def _solved(matrix: np.ndarray, right: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The least squares solution; directions of which the matrix says nothing stay 0."""
    return np.linalg.pinv(matrix / np.outer(scale, scale), _NOTHING, True) @ (right / scale) / scale
