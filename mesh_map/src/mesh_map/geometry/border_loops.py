"""The border of a mesh as closed loops."""

from typing import Any, NamedTuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces

from mesh_map import _kernels


class BorderLoops(NamedTuple):
    """Simple closed ways along the border: none passes a vertex twice.

    offsets: (L + 1,) uint32; those of loop i are vertices[offsets[i]:offsets[i + 1]].
    vertices: (N,) uint32, in the order in which the faces beside run along the border.
    faces: (N,) uint32, the face at the edge from each vertex to the next one of its loop.
    open_edges: border edges that are in no loop: the way around one of their vertices leads to an
        edge of more than two faces, or to a face that is turned otherwise (see make_manifold()).
    """

    offsets: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    open_edges: int

    @property
    def count(self) -> int:
        """L."""
        return len(self.offsets) - 1

    def perimeters(self, points: Any) -> np.ndarray:
        """(L,) float64 meters; points: (V, 3) of all vertices."""
        around = np.asarray(points, np.float64)[self.vertices]
        following = np.arange(1, len(around) + 1)
        following[self.offsets[1:].astype(np.int64) - 1] = self.offsets[:-1]
        lengths = np.linalg.norm(around[following] - around, axis=1) if len(around) else np.zeros(0)
        return np.add.reduceat(lengths, self.offsets[:-1]) if self.count else np.zeros(0)


def border_loops(faces: Any, vertex_count: int) -> BorderLoops:
    """The loops of the border, in the order of the faces.

    What bounds one piece of surface is one loop, also where another one touches it in a vertex;
    where a border comes back to a vertex, as where two holes touch, it is cut into two loops.

    Args:
        faces: (F, 3) vertex indices.
        vertex_count: V.
    Raises:
        ValueError: a face that refers to no vertex, or a wrong shape.
    """
    return BorderLoops(*_kernels._border_loops(as_faces(faces), vertex_count))
