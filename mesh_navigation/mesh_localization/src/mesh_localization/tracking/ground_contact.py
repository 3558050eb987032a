"""A robot that stands on the map: its height and tilt, as far as nothing better is known."""

from typing import Tuple

import numpy as np
from mesh_map.base.rotation import rotated
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.registration.rigid import inverse, motion, moved, numbers_of
from mesh_map.spatial.hits import NO_FACE

_HALF = 0.2  # m from the middle of the base to where it stands
_FEET = _HALF * np.array([[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]], np.float64)
_DEVIATION = 0.05  # m of a foot from the surface: tires, bumps, errors of the map
_UP = (0.0, 0.0, 1.0)
_REACH = 1.0  # m from a foot to the ground that it stands on
_STEEPEST = 1.1  # rad: walls are no ground
_STEPS, _DONE = 5, 1e-4


class GroundContact:
    """Four points below the base that stand on the surface, each as good as 5 cm."""

    def __init__(self, target: PlaneTarget, base_height: float) -> None:
        """
        Args:
            target: the map.
            base_height: m of the base above the ground.
        """
        self._target = target
        self._feet = _FEET - [0.0, 0.0, base_height]

    def put_down(self, pose: np.ndarray, covariance: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """A pose and its covariance, knowing that the robot stands; as they are where no ground is
        within a meter of a foot.

        Args:
            pose: (4, 4) of the base.
            covariance: (6, 6) in the frame of the base.
        """
        known = np.linalg.inv(covariance)
        found, information = pose, np.zeros((6, 6))
        for _ in range(_STEPS):
            rows, heights = self._rows(found)
            if not len(rows):
                return pose, covariance
            information = np.einsum("ni,nj->ij", rows, rows) / _DEVIATION**2
            right = -np.einsum("ni,n->i", rows, heights) / _DEVIATION**2
            right -= known @ numbers_of(inverse(pose) @ found)
            step = np.linalg.solve(information + known, right)
            found = found @ motion(step)
            if np.abs(step).max() < _DONE:
                break
        return found, np.linalg.inv(information + known)

    def height(self, pose: np.ndarray) -> float:
        """m of the feet above the ground, in the mean; NaN where there is none."""
        heights = self._rows(pose)[1]
        return float(heights.mean()) if len(heights) else float("nan")

    def _rows(self, pose: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Of each foot that has ground, how its height changes by a small motion (N, 6), and its
        height over the plane there (N,) m."""
        feet = moved(pose, self._feet)
        hits = self._target.index.closest_batch(
            points=feet,
            max_distance=_REACH,
            normals=_UP,
            max_angle=_STEEPEST,
            back_end="native",
        )
        there = hits.faces != NO_FACE
        normals = self._target.normals[hits.faces[there]]
        heights = np.einsum("ij,ij->i", normals, feet[there] - hits.positions[there])
        own = rotated(normals, pose[:3, :3].T)
        return np.concatenate([own, np.cross(self._feet[there], own)], axis=1), heights
