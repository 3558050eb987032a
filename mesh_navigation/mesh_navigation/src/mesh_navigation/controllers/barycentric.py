"""Barycentric coordinates."""

import numpy as np

from mesh_navigation.controllers.vector3 import dot, minus


def barycentric(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(N,3) weights of the corners (3,3) of a face with an area at points (N,3) of it."""
    first, second, offsets = corners[1] - corners[0], corners[2] - corners[0], points - corners[0]
    a, b, c = first @ first, first @ second, second @ second
    with_first, with_second = offsets @ first, offsets @ second
    area = a * c - b * b
    weights = np.zeros((len(points), 3))
    weights[:, 1] = (c * with_first - b * with_second) / area
    weights[:, 2] = (a * with_second - b * with_first) / area
    weights[:, 0] = 1.0 - weights[:, 1] - weights[:, 2]
    return weights


def inside(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(3,) weights at one point (3,), moved into the face where rounding has put it beside; NaN
    where the face has no area."""
    # Number by number: for one point NumPy takes ten times as long.
    origin, second, third = corners.tolist()
    side, other, offset = minus(second, origin), minus(third, origin), minus(point.tolist(), origin)
    a, b, c = dot(side, side), dot(side, other), dot(other, other)
    along, across = dot(offset, side), dot(offset, other)
    area = a * c - b * b
    if area == 0.0:
        return np.full(3, np.nan)  # no walk begins there
    v, w = (c * along - b * across) / area, (a * across - b * along) / area
    weights = [min(max(weight, 0.0), 1.0) for weight in (1.0 - v - w, v, w)]
    total = sum(weights)
    return np.array([weight / total for weight in weights])
