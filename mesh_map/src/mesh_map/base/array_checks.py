"""Arrays of a mesh in the form that the kernels take: dtype, shape, C order."""

import operator
from typing import Any

import numpy as np


def as_vertices(vertices: Any) -> np.ndarray:
    """(V, 3) float32 in C order; a copy only where that is needed.

    Raises:
        ValueError: another shape, or no numbers.
    """
    return _rows(vertices, np.float32, "vertices")


def as_faces(faces: Any) -> np.ndarray:
    """(F, 3) uint32 in C order; a copy only where that is needed.

    Raises:
        ValueError: another shape, no whole numbers, or one that uint32 cannot hold.
    """
    array = np.asarray(faces)
    if array.size == 0:
        array = array.astype(np.uint32)
    if array.dtype != np.uint32:
        if array.dtype.kind not in "iu":
            raise ValueError("faces have to be whole numbers, not %s" % array.dtype)
        wrong = np.flatnonzero(((array < 0) | (array > 0xFFFFFFFF)).ravel())
        if len(wrong):
            raise ValueError(
                "face %d refers to vertex %d, which no mesh can have (%d such in all)"
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


def read_only(array: np.ndarray) -> np.ndarray:
    """The same memory as an array that cannot be written through."""
    view = array.view()
    view.flags.writeable = False
    return view


def vertex_indices(vertices: Any, count: int, what: str) -> np.ndarray:
    """(N,) uint32 of these vertices, once they are known to exist.

    Args:
        vertices: whole numbers.
        count: of the vertices that there are.
        what: they are, for the message, such as "source ".
    Raises:
        ValueError: one that does not exist (the first is named), or no whole numbers.
    """
    if isinstance(vertices, np.ndarray):
        if vertices.ndim != 1 or vertices.dtype.kind not in "iu":
            raise ValueError("%svertices have to be a row of whole numbers" % what)
        wrong = vertices[(vertices < 0) | (vertices >= count)]
    else:
        vertices = [operator.index(vertex) for vertex in vertices]
        wrong = [vertex for vertex in vertices if not 0 <= vertex < count]
    if len(wrong):
        raise ValueError(
            "%svertex %d does not exist: there are %d vertices" % (what, wrong[0], count)
        )
    return np.ascontiguousarray(vertices, np.uint32)
