"""Poses that agree best with what was measured between them: a pose graph (F. Lu and E. Milios:
Globally Consistent Range Scan Alignment for Environment Mapping, 1997)."""

from typing import TYPE_CHECKING, List, NamedTuple, Sequence, Tuple

import numpy as np

from mesh_map.registration.rigid import adjoint, inverse, motion, numbers_of

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

_DONE, _SMALL = 1e-9, 1e-5  # share of the cost, m and rad; smaller changes are the last
_MOST_DAMPING = 1e9


class PoseEdge(NamedTuple):
    """What was measured between two poses.

    Attributes:
        first, second: numbers of the poses.
        measured: (4, 4), of the second in the frame of the first.
        information: (6, 6), the inverse of its covariance in the frame of the second (m, rad).
        doubt: standard deviations from which on it counts less and less (Cauchy); inf: it always
            counts in full.
    """

    first: int
    second: int
    measured: np.ndarray
    information: np.ndarray
    doubt: float = np.inf


def optimized(
    poses: Sequence[np.ndarray], edges: Sequence[PoseEdge], steps: int = 50
) -> List[np.ndarray]:
    """Poses with the least weighted squares of what edges are off, by Levenberg's and Marquardt's
    method (D. Marquardt, 1963); the first pose stays.

    Args:
        poses: (4, 4) each, to begin with.
        edges: each pose has to be reached from the first one.
        steps: at most.
    """
    from scipy.sparse import diags
    from scipy.sparse.linalg import spsolve

    result = [np.array(pose, np.float64) for pose in poses]
    count = len(result) - 1
    if not count or not edges:
        return result
    cost, damping = _cost(result, edges), 1e-6
    matrix, right = _normal_equations(result, edges)
    for _ in range(steps):
        change = spsolve(matrix + damping * diags(matrix.diagonal(), format="csc"), right)
        changed = result[:1] + [
            pose @ motion(numbers) for pose, numbers in zip(result[1:], change.reshape(count, 6))
        ]
        new_cost = _cost(changed, edges)
        if not new_cost <= cost:
            damping *= 10
            if damping > _MOST_DAMPING:
                break
            continue
        result, damping = changed, max(damping / 10, 1e-9)
        done = cost - new_cost <= _DONE * cost and np.abs(change).max() < _SMALL
        cost = new_cost
        if done:
            break
        matrix, right = _normal_equations(result, edges)
    return result


def _error(poses: Sequence[np.ndarray], edge: PoseEdge) -> Tuple[np.ndarray, np.ndarray, float]:
    """(6,) by which an edge is off; the second pose in the frame of the first; squared standard
    deviations."""
    between = inverse(poses[edge.first]) @ poses[edge.second]
    error = numbers_of(inverse(edge.measured) @ between)
    return error, between, float(error @ edge.information @ error)


def _cost(poses: Sequence[np.ndarray], edges: Sequence[PoseEdge]) -> float:
    cost = 0.0
    for edge in edges:
        square = _error(poses, edge)[2]
        if not np.isinf(edge.doubt):
            square = edge.doubt**2 * np.log1p(square / edge.doubt**2)
        cost += square
    return cost


def _normal_equations(
    poses: Sequence[np.ndarray], edges: Sequence[PoseEdge]
) -> Tuple["csc_matrix", np.ndarray]:
    from scipy.sparse import coo_matrix

    size = 6 * (len(poses) - 1)
    block_rows, block_columns = np.divmod(np.arange(36), 6)
    rows, columns, values = [], [], []
    right = np.zeros(size)
    for edge in edges:
        error, between, square = _error(poses, edge)
        weight = 1.0 if np.isinf(edge.doubt) else 1 / (1 + square / edge.doubt**2)
        information = weight * edge.information
        # A small motion of the second pose changes the error as it is; one of the first, as seen
        # from the second.
        changes = {edge.first: -adjoint(inverse(between)), edge.second: np.eye(6)}
        for one, left in changes.items():
            if one == 0:
                continue
            right[6 * one - 6 : 6 * one] -= left.T @ information @ error
            for other, change in changes.items():
                if other != 0:
                    rows.append(6 * (one - 1) + block_rows)
                    columns.append(6 * (other - 1) + block_columns)
                    values.append((left.T @ information @ change).ravel())
    indices = np.concatenate(rows), np.concatenate(columns)
    return coo_matrix((np.concatenate(values), indices), shape=(size, size)).tocsc(), right
