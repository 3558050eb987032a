"""Vertices and faces as arrays of the type that kernels, files and identities take."""

from typing import Any

import numpy as np


def as_vertices(vertices: Any) -> np.ndarray:
    """(V, 3) float32 in C order; a copy only where that is needed.

    What float32 cannot hold becomes infinite.

    Raises:
        ValueError: another shape, or no numbers.
    """
    return _rows(vertices, np.float32, "vertices")


def as_faces(faces: Any, kinds: str = "iu") -> np.ndarray:
    """(F, 3) uint32 in C order; a copy only where that is needed.

    Args:
        faces: vertex indices.
        kinds: of dtypes that they may be of; with "f" floats, too, that are whole numbers.
    Raises:
        ValueError: another shape, no whole numbers, or one that uint32 cannot hold.
    """
    array = np.asarray(faces)
    if array.size == 0:
        array = array.astype(np.uint32)
    if array.dtype != np.uint32:
        if array.dtype.kind not in kinds:
            raise ValueError("faces have to be whole numbers, not %s" % array.dtype)
        fits = (array >= 0) & (array <= 0xFFFFFFFF)
        if array.dtype.kind == "f":
            fits &= array == np.floor(array)
        wrong = np.flatnonzero(~fits.ravel())
        if len(wrong):
            raise ValueError(
                "face %d refers to vertex %s, which no mesh can have (%d such in all)"
                % (wrong[0] // 3, array.ravel()[wrong[0]], len(wrong))
            )
    return _rows(array, np.uint32, "faces")


def _rows(values: Any, dtype: Any, name: str) -> np.ndarray:
    array = np.asarray(values)
    if array.size == 0 and array.shape in ((0,), (0, 3)):
        return np.zeros((0, 3), dtype)
    if array.dtype.kind not in "fiu":
        raise ValueError("%s have to be numbers, not %s" % (name, array.dtype))
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError("%s have to have the shape (N, 3), not %s" % (name, array.shape))
    with np.errstate(over="ignore"):  # what does not fit becomes infinite, which is looked for
        return np.ascontiguousarray(array, dtype)
