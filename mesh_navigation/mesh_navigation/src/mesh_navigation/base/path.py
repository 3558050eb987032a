"""From points on a surface to poses of a robot that follows them."""

import math
from typing import Tuple

import numpy as np

from mesh_navigation.base.pose import quaternions_from_axes

# Points closer than this are one point (m): it is far below the resolution of any map.
SAME_POINT = 1e-7
# A path that lies in a surface keeps as near to it when points of it are left out (m).
STRAIGHT = 1e-4


def path_length(points: np.ndarray) -> float:
    """Length (m) of the polyline through (N,3) points."""
    return float(_lengths(points).sum())


def without_repeats(points: np.ndarray, normals: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """The polyline without segments of no length; the first and the last point always stay.

    ``points`` and ``normals`` are (N,3) with N at least 2, and so are the results.
    """
    if np.all(_lengths(points) > SAME_POINT):
        return points, normals
    places = points.tolist()
    kept = [0]
    for index in range(1, len(places) - 1):
        if math.dist(places[index], places[kept[-1]]) > SAME_POINT:
            kept.append(index)
    if len(kept) > 1 and math.dist(places[-1], places[kept[-1]]) <= SAME_POINT:
        kept.pop()
    kept.append(len(places) - 1)
    return points[kept], normals[kept]


def spaced_out(points: np.ndarray, step: float) -> Tuple[np.ndarray, np.ndarray]:
    """The same polyline with points at its bends and at most ``step`` apart.

    Points that it passes nearly straight are left out, where it stays within `STRAIGHT` of all of
    them: then it also stays that near to any surface in which it lies. Others are put in between.

    Args:
        points: (N,3) m, N at least 2.
        step: m, above 0.

    Returns:
        (M,3) points, and (M,) indices of the segments of ``points`` that begin there or contain
        them; for the last point, the segment that ends there.
    """
    kept = _without_straight(points, step)
    parts = np.maximum(np.ceil(_lengths(points[kept]) / step * (1 - 1e-9)), 1).astype(np.int64)
    first = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(first)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[first]
    starts, ends = points[kept[:-1]], points[kept[1:]]
    spaced = starts[first] + share[:, None] * (ends - starts)[first]
    # What is longer than a step is one segment: points between its ends are in that one.
    return np.concatenate([spaced, points[-1:]]), np.append(kept[:-1][first], len(points) - 2)


def _without_straight(points: np.ndarray, step: float) -> np.ndarray:
    """(K,) ascending indices of the points that stay; those left out are within `STRAIGHT`."""
    travelled = np.append(0.0, np.cumsum(_lengths(points)))
    within = (np.searchsorted(travelled, travelled + step, side="right") - 1).tolist()
    bends = _distances_from_line(points[1:-1], points[:-2], points[2:]) > STRAIGHT
    kept = [0]
    for following in [*(np.flatnonzero(bends) + 1).tolist(), len(points) - 1]:
        while kept[-1] < following:
            here = kept[-1]
            farthest = min(within[here], following)
            # The one point between here and here + 2 is no bend, or it would stay.
            last = max(min(here + 2, farthest), here + 1)
            while last < farthest:
                longer = min(2 * last - here, farthest)
                between = points[here + 1 : longer]
                if np.any(_distances_from_line(between, points[here], points[longer]) > STRAIGHT):
                    break
                last = longer
            kept.append(last)
    return np.array(kept)


def _lengths(points: np.ndarray) -> np.ndarray:
    """(N - 1,) lengths of the segments of a polyline."""
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def _distances_from_line(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(N,) distances of points from the straight ways between a and b, (N,3) or (3,) each."""
    along, offset = b - a, points - a
    squared = np.sum(along * along, axis=-1)
    share = np.sum(offset * along, axis=-1) / np.where(squared > 0, squared, 1)
    nearest = np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(offset - nearest, axis=-1)


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
    is_usable = np.linalg.norm(flat, axis=1) > 1e-3
    usable = np.flatnonzero(is_usable)
    for index in np.flatnonzero(~is_usable):
        before = usable[usable < index]
        neighbors = [flat[before[-1]]] if len(before) else [flat[i] for i in usable[:1]]
        flat[index] = _in_plane(neighbors + list(np.eye(3)), normals[index])
    return flat / np.linalg.norm(flat, axis=1, keepdims=True)


def _in_plane(candidates: list, normal: np.ndarray) -> np.ndarray:
    """The first candidate direction with a part in the plane of ``normal``, projected into it."""
    projected = [candidate - np.dot(candidate, normal) * normal for candidate in candidates]
    return next(vector for vector in projected if np.linalg.norm(vector) > 1e-3)
