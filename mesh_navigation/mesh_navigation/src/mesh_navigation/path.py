"""From points on a surface to poses of a robot that follows them."""

from typing import Tuple

import numpy as np

from mesh_navigation.pose import quaternions_from_axes

# Points closer than this are one point (m): it is far below the resolution of any map.
SAME_POINT = 1e-7


def path_length(points: np.ndarray) -> float:
    """Length (m) of the polyline through (N,3) points."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def without_repeats(points: np.ndarray, normals: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """The polyline without segments of no length; the first and the last point always stay.

    ``points`` and ``normals`` are (N,3) with N at least 2, and so are the results.
    """
    keep = np.ones(len(points), dtype=bool)
    last = 0
    for index in range(1, len(points) - 1):
        keep[index] = np.linalg.norm(points[index] - points[last]) > SAME_POINT
        last = index if keep[index] else last
    if last != 0 and np.linalg.norm(points[-1] - points[last]) <= SAME_POINT:
        keep[last] = False
    return points[keep], normals[keep]


def path_poses(points: np.ndarray, normals: np.ndarray, goal_heading: np.ndarray) -> np.ndarray:
    """Poses along a polyline.

    Args:
        points: (N,3) m, N at least 2.
        normals: (N,3) unit normals of the surface there, pointing up.
        goal_heading: (3,) where the robot shall look at the end; its part along the surface counts.

    Returns:
        (N,7) float64: position x, y, z (m) and quaternion x, y, z, w. z is the normal, x looks at
        the next point as far as the surface allows, in the last pose along ``goal_heading``.
    """
    points = np.asarray(points, dtype=np.float64)
    z = np.asarray(normals, dtype=np.float64)
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    steps = np.diff(points, axis=0)
    wished = np.concatenate([steps, np.asarray(goal_heading, dtype=np.float64)[None]])
    x = _along_surface(wished, z)
    y = np.cross(z, x)
    return np.concatenate([points, quaternions_from_axes(x, y, z)], axis=1)


def _along_surface(directions: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(N,3) unit vectors: the directions projected into the planes of the normals.

    A direction without such a part (straight up a step, no movement) takes over that of the pose
    before it, or else of the first pose after it, or else any one in the plane.
    """
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    units = directions / np.where(lengths > SAME_POINT, lengths, np.inf)
    flat = units - np.sum(units * normals, axis=1, keepdims=True) * normals
    usable = np.flatnonzero(np.linalg.norm(flat, axis=1) > 1e-3)
    for index in range(len(flat)):
        if np.linalg.norm(flat[index]) > 1e-3:
            continue
        before = usable[usable < index]
        neighbors = [flat[before[-1]]] if len(before) else [flat[i] for i in usable[:1]]
        flat[index] = _in_plane(neighbors + list(np.eye(3)), normals[index])
    return flat / np.linalg.norm(flat, axis=1, keepdims=True)


def _in_plane(candidates: list, normal: np.ndarray) -> np.ndarray:
    """The first candidate direction with a part in the plane of ``normal``, projected into it."""
    projected = [candidate - np.dot(candidate, normal) * normal for candidate in candidates]
    return next(vector for vector in projected if np.linalg.norm(vector) > 1e-3)
