"""Where something that moves was, and how it was turned, at any moment."""

from dataclasses import dataclass
from typing import Any, List, Tuple

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.base.errors import MeshMapError

_STRAIGHT = 1e-6  # rad between two orientations, below which sin(angle) / angle is 1
_UNIT = 1e-3  # by which a quaternion may be off the length 1, and a matrix off a rotation


@dataclass(frozen=True)
class Trajectory:
    """Poses of a frame in the map's at ascending times, and between them: translations linear,
    rotations by slerp (Shoemake, Animating rotation with quaternion curves, 1985).

    Attributes:
        times: (K,) float64 s, strictly ascending.
        positions: (K, 3) float64 m.
        orientations: (K, 4) float64, unit quaternions x, y, z, w.
    """

    times: np.ndarray
    positions: np.ndarray
    orientations: np.ndarray

    def __post_init__(self) -> None:
        """
        Raises:
            MeshMapError: other shapes, numbers that are not finite, times that do not ascend, or
                quaternions that are not of length 1 (within 0.1 %).
        """
        times = np.array(self.times, np.float64)
        positions = np.array(self.positions, np.float64)
        orientations = np.array(self.orientations, np.float64)
        count = len(times) if times.ndim == 1 else 0
        if not count or positions.shape != (count, 3) or orientations.shape != (count, 4):
            text = "a trajectory of times %s, positions %s and orientations %s"
            shapes = times.shape, positions.shape, orientations.shape
            raise MeshMapError(text % shapes, "(K,), (K, 3) and (K, 4) are needed, K >= 1")
        lengths = np.linalg.norm(orientations, axis=1)
        wrong = ~(np.isfinite(times) & np.isfinite(positions).all(1) & (abs(lengths - 1) <= _UNIT))
        wrong[1:] |= ~(np.diff(times) > 0)
        if wrong.any():
            text = "%d of %d poses of a trajectory cannot be used; the first is pose %d"
            hint = "finite numbers, ascending times and quaternions of length 1 are needed"
            raise MeshMapError(text % (wrong.sum(), count, np.argmax(wrong)), hint)
        object.__setattr__(self, "times", read_only(times))
        object.__setattr__(self, "positions", read_only(positions))
        object.__setattr__(self, "orientations", read_only(orientations / lengths[:, None]))

    @classmethod
    def of_matrices(cls, matrices: Any, times: Any) -> "Trajectory":
        """Of poses (K, 4, 4) at times (K,) s.

        Raises:
            MeshMapError: no poses: another shape, or rotations that are none.
        """
        poses = np.asarray(matrices, np.float64)
        if poses.ndim != 3 or poses.shape[1:] != (4, 4):
            raise MeshMapError("poses of the shape %s" % (poses.shape,), "(N, 4, 4) is needed")
        turns = poses[:, :3, :3]
        with np.errstate(all="ignore"):
            off = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max((1, 2))
            wrong = ~((off < _UNIT) & (np.linalg.det(np.nan_to_num(turns)) > 0))
        if wrong.any():
            text = "%d of %d poses are no rotation and translation; the first is pose %d"
            raise MeshMapError(text % (wrong.sum(), len(poses), np.argmax(wrong)))
        return cls(times, poses[:, :3, 3], quaternions_of(turns))

    def at(self, times: Any) -> Tuple[np.ndarray, np.ndarray]:
        """Positions (N, 3) m and rotations (N, 3, 3) at times (N,) s; the first and the last pose
        where they are before or behind all."""
        moments = np.clip(np.asarray(times, np.float64), self.times[0], self.times[-1])
        if len(self.times) == 1:
            before = after = np.zeros(len(moments), np.int64)
            share = np.zeros(len(moments))
        else:
            last = len(self.times) - 2
            before = np.clip(np.searchsorted(self.times, moments, "right") - 1, 0, last)
            after = before + 1
            share = (moments - self.times[before]) / (self.times[after] - self.times[before])
        first, second = self.positions[before], self.positions[after]
        positions = first + share[:, None] * (second - first)
        turned = _slerp(self.orientations[before], self.orientations[after], share)
        return positions, rotations_of(turned)

    def poses(self, times: Any) -> np.ndarray:
        """(N, 4, 4) float64 at times (N,) s, as at()."""
        positions, rotations = self.at(times)
        poses = np.zeros((len(positions), 4, 4))
        poses[:, :3, :3], poses[:, :3, 3], poses[:, 3, 3] = rotations, positions, 1.0
        return poses

    def above(self, height: float) -> "Trajectory":
        """That of a point which is so much (m) above, along the own z axis, and turns with it."""
        up = rotations_of(self.orientations)[:, :, 2]
        return Trajectory(self.times, self.positions + height * up, self.orientations)

    def resampled(self, rate: float) -> "Trajectory":
        """Poses at the rate (Hz) at which they are to be told, from the first one on, as far as the
        last. Who interpolates between those gets exactly this."""
        count = int(np.floor((self.times[-1] - self.times[0]) * rate + 1e-9)) + 1
        times = self.times[0] + np.arange(count) / rate
        positions, rotations = self.at(times)
        return Trajectory(times, positions, quaternions_of(rotations))

    @property
    def length(self) -> float:
        """m from pose to pose."""
        return float(np.linalg.norm(np.diff(self.positions, axis=0), axis=1).sum())


def _slerp(first: np.ndarray, second: np.ndarray, share: np.ndarray) -> np.ndarray:
    """(N, 4) unit quaternions on the shorter arcs between those of two arrays (N, 4)."""
    cosine = np.sum(first * second, axis=-1)
    second = np.where(cosine[:, None] < 0, -second, second)
    angle = np.arccos(np.minimum(abs(cosine), 1.0))
    sine = np.where(angle > _STRAIGHT, np.sin(angle), 1.0)
    begin = np.where(angle > _STRAIGHT, np.sin((1 - share) * angle) / sine, 1 - share)
    end = np.where(angle > _STRAIGHT, np.sin(share * angle) / sine, share)
    turned = begin[:, None] * first + end[:, None] * second
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)


def rotations_of(quaternions: np.ndarray) -> np.ndarray:
    """(N, 3, 3) rotations of unit quaternions (N, 4) x, y, z, w."""
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def quaternions_of(rotations: np.ndarray) -> np.ndarray:
    """(N, 4) unit quaternions x, y, z, w >= 0 of rotations (N, 3, 3): of each the eigenvector of
    Bar-Itzhack's matrix (New method for extracting the quaternion from a rotation matrix, 2000)."""
    m = rotations
    rows: List[List[np.ndarray]] = [
        [m[:, 0, 0] - m[:, 1, 1] - m[:, 2, 2], m[:, 0, 1] + m[:, 1, 0]],
        [m[:, 0, 1] + m[:, 1, 0], m[:, 1, 1] - m[:, 0, 0] - m[:, 2, 2]],
        [m[:, 0, 2] + m[:, 2, 0], m[:, 1, 2] + m[:, 2, 1]],
        [m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0]],
    ]
    rows[0] += [m[:, 0, 2] + m[:, 2, 0], m[:, 2, 1] - m[:, 1, 2]]
    rows[1] += [m[:, 1, 2] + m[:, 2, 1], m[:, 0, 2] - m[:, 2, 0]]
    rows[2] += [m[:, 2, 2] - m[:, 0, 0] - m[:, 1, 1], m[:, 1, 0] - m[:, 0, 1]]
    rows[3] += [m[:, 1, 0] - m[:, 0, 1], m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]]
    matrices = np.moveaxis(np.array(rows), (0, 1), (-2, -1))
    found = np.linalg.eigh(matrices)[1][:, :, -1]
    return np.where(found[:, 3:] < 0, -found, found)


def quaternion_product(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(N, 4) Hamilton products of quaternions (N, 4): the rotations `second`, then `first`."""
    x1, y1, z1, w1 = first.T
    x2, y2, z2, w2 = second.T
    return np.stack(
        [
            w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
            w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
            w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
            w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
        ],
        axis=1,
    )
