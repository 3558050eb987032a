"""Poses of scans in text files: KITTI's and TUM's, as 4 x 4 matrices of a scan in the map.

KITTI (odometry benchmark): a line of 12 numbers, the upper three rows of the matrix. TUM (RGB-D
benchmark): timestamp tx ty tz qx qy qz qw.
"""
from typing import List, NamedTuple, Optional, Sequence

import numpy as np

from mesh_msgs_hdf5.files.probe import read_file
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

FORMATS = ("kitti", "tum")
_MOST_BYTES = 1 << 28
_ROUNDED = 1e-3  # by which rows of a rotation that was printed may be off


class ScanPose(NamedTuple):
    """matrix: (4, 4) float64, from the scan to the map; time: seconds, or None."""

    matrix: np.ndarray
    time: Optional[float] = None


def read_poses(path: PathLike) -> List[ScanPose]:
    """One for each line. Raises MapFileError."""
    data = read_file(path)
    if len(data) > _MOST_BYTES:
        raise MapFileError("size", path, "it has %d bytes" % len(data), "is it a file of poses?")
    poses: List[ScanPose] = []
    for number, line in enumerate(data.decode("latin-1").splitlines(), 1):
        words = line.split("#")[0].split()
        if words:
            poses.append(_pose(path, number, words))
    return poses


def _pose(path, number, words):
    try:
        values = np.array(words, np.float64)
    except ValueError:
        values = np.full(1, np.nan)
    if len(values) not in (8, 12) or not np.isfinite(values).all():
        text = "line %d has not 12 numbers (KITTI) or 8 (TUM)" % number
        raise MapFileError("format", path, text, "x y z and a rotation, one scan a line")
    matrix = np.eye(4)
    if len(values) == 12:
        matrix[:3] = values.reshape(3, 4)
        check_rigid(path, "line %d" % number, matrix)
        return ScanPose(matrix)
    matrix = matrix_of(path, "line %d" % number, values[1:4], values[4:])
    return ScanPose(matrix, float(values[0]))


def matrix_of(
    path: PathLike, where: str, place: Sequence[float], quaternion: Sequence[float]
) -> np.ndarray:
    """(4, 4) of a translation x y z and a rotation x y z w. Raises MapFileError (value)."""
    numbers = np.array([*place, *quaternion], np.float64)
    length = np.linalg.norm(numbers[3:])
    if not np.isfinite(numbers).all() or abs(length - 1) > _ROUNDED:
        text = "%s has a quaternion of length %g" % (where, length)
        raise MapFileError("value", path, text, "a place and a rotation, of length 1")
    x, y, z, w = numbers[3:] / length
    matrix = np.eye(4)
    matrix[:3, 3] = numbers[:3]
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return matrix


def check_rigid(path: PathLike, where: str, matrix: np.ndarray) -> None:
    """Refuse a (4, 4) matrix that is no rotation and translation."""
    turn = matrix[:3, :3]
    with np.errstate(all="ignore"):
        off = np.abs(turn @ turn.T - np.eye(3)).max() if np.isfinite(matrix).all() else np.inf
        sound = off < 10 * _ROUNDED and np.linalg.det(turn) > 0
    if not sound or (matrix[3] != (0, 0, 0, 1)).any():
        text = "the pose of %s is no rotation and translation" % where
        raise MapFileError("value", path, text, "a matrix of scans to the map, without scale")


def pose_lines(poses: Sequence[ScanPose], form: str) -> str:
    """A line for each, of those of TUM with their times."""
    lines = []
    for matrix, time in poses:
        if form == "kitti":
            numbers = matrix[:3].ravel().tolist()
        else:
            numbers = [float(time)] + matrix[:3, 3].tolist() + quaternion_of(matrix[:3, :3])
        lines.append(" ".join(map(repr, numbers)) + "\n")
    return "".join(lines)


def quaternion_of(turn: np.ndarray) -> List[float]:
    """x, y, z, w of a rotation (3, 3): the eigenvector of Bar-Itzhack's matrix (2000)."""
    (a, b, c), (d, e, f), (g, h, i) = turn
    matrix = np.array(
        [
            [a - e - i, b + d, c + g, h - f],
            [b + d, e - a - i, f + h, c - g],
            [c + g, f + h, i - a - e, d - b],
            [h - f, c - g, d - b, a + e + i],
        ]
    )
    vector = np.linalg.eigh(matrix)[1][:, -1]
    return (vector if vector[3] >= 0 else -vector).tolist()
