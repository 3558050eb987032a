"""Poses and quaternions as NumPy arrays, quaternions as x, y, z, w like those of geometry_msgs."""

import math
from typing import NamedTuple, Optional, Sequence

import numpy as np


class Pose(NamedTuple):
    """A pose in the map's frame."""

    position: np.ndarray
    """(3,) float64, m."""
    orientation: np.ndarray
    """(4,) float64, unit quaternion x, y, z, w."""

    @classmethod
    def at(cls, position: Sequence[float], yaw: float = 0.0) -> "Pose":
        """Upright pose at ``position`` (m), turned by ``yaw`` (rad) about z."""
        turn = np.array([0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)])
        return cls(np.asarray(position, dtype=np.float64), turn)

    @property
    def heading(self) -> np.ndarray:
        """(3,) unit vector of the x axis."""
        return rotate(self.orientation, np.array([1.0, 0.0, 0.0]))

    def fault(self) -> Optional[str]:
        """What makes this no pose, as a phrase, or None."""
        shapes = np.shape(self.position), np.shape(self.orientation)
        if shapes != ((3,), (4,)):
            return (
                f"position and orientation have shapes {shapes[0]} and {shapes[1]}, not (3,), (4,)"
            )
        if not np.all(np.isfinite(self.position)):
            return f"position {vector_text(self.position)} is not finite"
        if not np.all(np.isfinite(self.orientation)):
            return f"orientation {vector_text(self.orientation)} is not finite"
        if not _MIN_NORM < np.linalg.norm(self.orientation) < 1 / _MIN_NORM:
            return (
                f"orientation {vector_text(self.orientation)} is no rotation (none at all: w = 1)"
            )
        return None

    def normalized(self) -> "Pose":
        """The same pose with a quaternion of length 1."""
        return Pose(self.position, self.orientation / np.linalg.norm(self.orientation))


_MIN_NORM = 1e-6


def vector_text(values: Sequence[float]) -> str:
    """``(1.00, -2.50, nan)``: numbers for a message."""
    return "(" + ", ".join(map(number_text, values)) + ")"


def number_text(value: float) -> str:
    """``1.00``, and ``1.5e+300`` where all its digits would fill a line."""
    return f"{value:.2f}" if abs(value) < 1e9 else f"{value:.4g}"


def multiply(first: Sequence[float], second: Sequence[float]) -> np.ndarray:
    """Hamilton product of two quaternions: the rotation ``second``, then ``first``."""
    x1, y1, z1, w1 = map(float, first)
    x2, y2, z2, w2 = map(float, second)
    return np.array(
        [
            w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
            w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
            w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
            w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
        ]
    )


def rotate(quaternion: Sequence[float], vector: Sequence[float]) -> np.ndarray:
    """A (3,) vector turned by a unit quaternion."""
    # Number by number: for one vector np.cross takes ten times as long.
    x, y, z, w = map(float, quaternion)
    a, b, c = map(float, vector)
    i, j, k = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return np.array(
        [
            a + w * i + (y * k - z * j),
            b + w * j + (z * i - x * k),
            c + w * k + (x * j - y * i),
        ]
    )


def transformed(pose: Pose, frame: Pose) -> Pose:
    """A pose given in a frame, in the frame in which that has the given pose."""
    position, turn = frame.normalized()
    return Pose(rotate(turn, pose.position) + position, multiply(turn, pose.orientation))


def quaternion_from_axes(
    x_axis: Sequence[float], y_axis: Sequence[float], z_axis: Sequence[float]
) -> np.ndarray:
    """(4,) unit quaternion of a frame with these axes of length 1, as `quaternions_from_axes`."""
    # Number by number: for one frame NumPy takes twenty times as long.
    (a, d, g), (b, e, h), (c, f, i) = x_axis, y_axis, z_axis  # columns of the matrix
    trace = a + e + i
    rest = 1 - trace
    diagonal = (a + a + rest, e + e + rest, i + i + rest, 1 + trace)
    row = diagonal.index(max(diagonal))
    x, y, z, w = (
        (diagonal[0], b + d, c + g, h - f),
        (b + d, diagonal[1], f + h, c - g),
        (c + g, f + h, diagonal[2], d - b),
        (h - f, c - g, d - b, diagonal[3]),
    )[row]
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return np.array([x / length, y / length, z / length, w / length])


def quaternions_from_axes(x_axes: np.ndarray, y_axes: np.ndarray, z_axes: np.ndarray) -> np.ndarray:
    """(N,4) unit quaternions of frames whose axes are rows of three (N,3) arrays of unit vectors.

    Of Shepperd's (1978) four equivalent formulas each frame uses that with the largest divisor.
    """
    m = np.stack([x_axes, y_axes, z_axes], axis=-1)
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    turn = np.stack(
        [m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]], axis=-1
    )
    # Row i is the quaternion times four times its own i-th entry.
    scaled = np.zeros((len(m), 4, 4))
    scaled[:, :3, :3] = m + m.transpose(0, 2, 1)
    scaled[:, :3, 3] = scaled[:, 3, :3] = turn
    for i in range(3):
        scaled[:, i, i] += 1 - trace
    scaled[:, 3, 3] = 1 + trace
    largest = np.argmax(np.diagonal(scaled, axis1=1, axis2=2), axis=1)
    chosen = scaled[np.arange(len(m)), largest]
    return chosen / np.linalg.norm(chosen, axis=1, keepdims=True)
