"""Coordinates far from zero, such as those of a UTM zone, in float32: what rounding may take."""
from typing import Sequence

import numpy as np

_LOST = 1e-3  # m that rounding may take ...
_LOST_SHARE = 1e-6  # ... and of the diagonal of the mesh, whichever is more


def is_too_much(lost: float, vertices: np.ndarray) -> bool:
    """Whether rounding has changed a mesh so much that it should not be used.

    Args:
        lost: by how much a coordinate has changed at most, meters.
        vertices: (V, 3) float32, as they are after rounding.
    """
    if lost <= _LOST:
        return False
    low, high = _bounds(vertices)
    return lost > _LOST_SHARE * float(np.linalg.norm(high - low))


def suggested_origin(vertices: np.ndarray, origin: Sequence[float] = (0.0, 0.0, 0.0)) -> str:
    """An origin near to a mesh, in whole meters, as "500000.0, 5800000.0, 0.0".

    Args:
        vertices: (V, 3) float32.
        origin: (3,) meters, that was subtracted from them before.
    """
    low, high = _bounds(vertices)
    center = np.rint(low / 2 + high / 2 + np.asarray(origin, np.float64))
    return ", ".join("%.1f" % value for value in center + 0.0)


def _bounds(vertices):
    return (edge.astype(np.float64) for edge in (vertices.min(axis=0), vertices.max(axis=0)))
