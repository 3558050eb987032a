"""Arrays that cannot be written to, and indices of vertices."""

import operator
from typing import Any

import numpy as np


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
