"""Vectors of three numbers as tuples: for one or two of them NumPy takes ten times as long."""

import math
from typing import Optional, Sequence, Tuple

import numpy as np

Vector3 = Tuple[float, float, float]


def vector3(values: Sequence[float]) -> Vector3:
    """From anything with three numbers."""
    x, y, z = values
    return float(x), float(y), float(z)


def dot(a: Vector3, b: Vector3) -> float:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector3, b: Vector3) -> Vector3:
    """The vector product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def minus(a: Vector3, b: Vector3) -> Vector3:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def unit(a: Vector3) -> Optional[Vector3]:
    """Of length 1; None where there is no direction."""
    length = math.hypot(math.hypot(a[0], a[1]), a[2])
    if not length > 0.0:
        return None
    return a[0] / length, a[1] / length, a[2] / length


def along_plane(a: Vector3, normal: Vector3) -> Vector3:
    """What of a vector lies in the plane across a normal of length 1."""
    share = dot(a, normal)
    return a[0] - share * normal[0], a[1] - share * normal[1], a[2] - share * normal[2]


def signed_angle(start: Vector3, end: Vector3, normal: Vector3) -> float:
    """From one vector to another of the same plane (rad, -pi to pi), to the left positive."""
    return math.atan2(dot(cross(start, end), normal), dot(start, end))


def inside(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(3,) barycentric weights of the corners (3,3) of a face at a point (3,) of it, moved into the
    face where rounding has put it beside; NaN where the face has no area."""
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
