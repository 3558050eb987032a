"""A scan laid onto a surface: point-to-plane registration (Y. Chen and G. Medioni: Object Modelling
by Registration of Multiple Range Images, 1992)."""

from typing import NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.rotation import rotated
from mesh_map.registration.rigid import inverse, motion, moved, numbers_of
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex

_ENOUGH = 30  # points; fewer say nothing about six numbers
_DONE = 3e-4, 1e-4  # m and rad; smaller steps are the last
_SHRINK = 0.6  # of the distance within which points count, from step to step
_OVER = 0.9  # of the distance to the surface, that has to be along its normal
_MOST_TURN = 0.1  # rad in a step
_WEAK = 1e-3  # share of the largest eigenvalue below which a direction is left as it was


class Registration(NamedTuple):
    """Where a scan lies.

    Attributes:
        pose: (4, 4) float64, from the scan into the surface's frame.
        information: (6, 6): sums of squares of how the distances change by a small motion in the
            scan's frame (translation, rotation), 1 / m^2. Weak where the surface does not tell.
        count: points that lie on the surface at the end.
        share: of those within the first distance of it at the end, how many lie on it.
        residual: m, root mean square of their distances.
    """

    pose: np.ndarray
    information: np.ndarray
    count: int
    share: float
    residual: float


class PlaneTarget:
    """A surface that scans are laid onto, with the normals of its faces."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        """
        Args:
            vertices: (V, 3) m.
            faces: (F, 3), at least one; counter-clockwise seen from where sensors were.
        """
        self.index = SpatialIndex(vertices, faces, device="off")
        a, b, c = np.moveaxis(np.asarray(vertices, np.float64)[faces], 1, 0)
        normals = np.cross(b - a, c - a)
        lengths = np.linalg.norm(normals, axis=1)
        self.normals = normals / np.where(lengths > 0, lengths, 1)[:, None]

    def register(
        self,
        points: np.ndarray,
        pose: np.ndarray,
        *,
        origins: Optional[np.ndarray] = None,
        prior: Optional[np.ndarray] = None,
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
                Points count only where it saw the face from its front.
            prior: (6, 6), how sure `pose` is: the inverse of its covariance times the variance of a
                distance; None: the points alone decide.
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
        information, residual = np.zeros((6, 6)), np.inf
        for _ in range(steps):
            near, normals, distances = self._matches(points, starts, pose, limit, cancel)
            if len(near) < _ENOUGH:
                return None
            # The scan moves in its own frame: n . R (t + r x p), so that the derivatives are R^T n
            # and p x R^T n.
            own = rotated(normals, pose[:3, :3].T)
            rows = np.concatenate([own, np.cross(points[near], own)], axis=1)
            # Tukey's weights, so that what lies elsewhere does not pull.
            weights = (1 - np.minimum(1, np.abs(distances) / limit) ** 2) ** 2
            weighted = weights[:, None] * rows
            information = np.einsum("ni,nj->ij", weighted, rows)
            matrix, right = information, -np.einsum("ni,n->i", weighted, distances)
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
        count = len(self._matches(points, starts, pose, limit, cancel)[0])
        around = len(self._matches(points, starts, pose, max_distance, cancel)[0])
        return Registration(pose, information, count, count / max(1, around), residual)

    def _matches(
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


def _solved(matrix: np.ndarray, right: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The least squares solution; directions of which the matrix says nothing stay 0."""
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    told = values > _WEAK * values[-1]
    along = vectors[:, told]
    return along @ ((along.T @ (right / scale)) / values[told]) / scale
