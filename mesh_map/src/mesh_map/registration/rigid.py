"""Rigid motions as (4, 4) matrices, and small ones as six numbers: translation, then rotation."""

from typing import Any

import numpy as np

from mesh_map.base.rotation import rotated

_SMALL = 1e-8  # rad, below which sin(angle) / angle is 1


def skew(vectors: np.ndarray) -> np.ndarray:
    """(..., 3, 3): the matrices of the cross product with vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [zero, -z, y, z, zero, -x, -y, x, zero]
    return np.stack(rows, -1).reshape(vectors.shape[:-1] + (3, 3))


def motion(numbers: np.ndarray) -> np.ndarray:
    """(4, 4): a translation by the first three numbers (m), and a rotation about the others (rad),
    by Rodrigues' formula."""
    angle = float(np.linalg.norm(numbers[3:]))
    around = skew(np.asarray(numbers[3:], np.float64))
    once, twice = (1.0, 0.5) if angle < _SMALL else (np.sin(angle) / angle, None)
    if twice is None:
        twice = (1 - np.cos(angle)) / angle**2
    matrix = np.eye(4)
    matrix[:3, :3] += once * around + twice * around @ around
    matrix[:3, 3] = numbers[:3]
    return matrix


def numbers_of(matrix: np.ndarray) -> np.ndarray:
    """(6,): what `motion` makes the matrix of; the angle is at most pi."""
    turn = matrix[:3, :3]
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    sine, cosine = float(np.linalg.norm(axis)), (np.trace(turn) - 1) / 2
    angle = np.arctan2(sine, cosine)
    if sine > _SMALL:
        axis *= angle / sine
    elif cosine < 0:  # a half turn: any column of turn + 1 is along its axis
        column = (turn + np.eye(3))[:, np.argmax(np.diag(turn))]
        axis = np.pi * column / np.linalg.norm(column)
    return np.concatenate([matrix[:3, 3], axis])


def inverse(matrix: np.ndarray) -> np.ndarray:
    """(4, 4): the rigid motion back."""
    back = np.eye(4)
    back[:3, :3] = matrix[:3, :3].T
    back[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return back


def adjoint(matrix: np.ndarray) -> np.ndarray:
    """(6, 6): a small motion m after this one is the motion adjoint @ m before it."""
    turn, shift = matrix[:3, :3], skew(matrix[:3, 3])
    both = np.zeros((6, 6))
    both[:3, :3] = both[3:, 3:] = turn
    both[:3, 3:] = shift @ turn
    return both


def moved(matrix: np.ndarray, points: Any) -> np.ndarray:
    """(N, 3) float64: points in the frame that the matrix leads into."""
    return rotated(points, matrix[:3, :3]) + matrix[:3, 3]
