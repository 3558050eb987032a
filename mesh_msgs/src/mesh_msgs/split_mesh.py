"""Meshes that are split along the seams of textures, as derived meshes of those that are not.

Along a seam one point of the surface has several places in the textures. A mesh has one texture
coordinate for each vertex, so it needs copies of the vertices there, and the surface is cut. Its
parent has one vertex for each point.
"""

from typing import Any, Optional, Tuple

import numpy as np

from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices
from mesh_msgs.derived_mesh import DerivedMesh


def copies_fault(vertices: np.ndarray, originals: np.ndarray) -> Optional[str]:
    """What is wrong with a table of copies: which, and how many; None if nothing is.

    Args:
        vertices: (V, 3) float32 of the split mesh.
        originals: (C,) whole numbers: of each of the last C vertices, the one that it is a copy of.
    """
    if originals.ndim != 1 or not 0 < len(originals) < len(vertices):
        return "%s are not copies among %d vertices" % (list(originals.shape), len(vertices))
    count = len(vertices) - len(originals)
    wrong = (originals < 0) | (originals >= count)
    text = "copy %d is one of vertex %d, which is not among the first %d (%d such in all)"
    if not wrong.any():
        bits = np.ascontiguousarray(vertices).view(np.uint32)
        wrong = (bits[count:] != bits[originals]).any(axis=1)
        text = "copy %d is not where vertex %d is, one of the first %d (%d such in all)"
    if not wrong.any():
        return None
    first = int(wrong.argmax())
    return text % (first, originals[first], count, np.count_nonzero(wrong))


def original_vertices(vertex_count: int, originals: np.ndarray) -> np.ndarray:
    """(V,) int64: of each vertex of the split mesh that of its parent."""
    own = np.arange(vertex_count - len(originals))
    return np.concatenate([own, originals.astype(np.int64)])


class SplitMesh(DerivedMesh):
    """A mesh with copies of some vertices of its parent behind all of these; in the same order the
    same faces, some of which have copies as corners.

    Attributes:
        originals: (C,) uint32, read-only: of each copy the parent's vertex.
    """

    def __init__(
        self, uuid: str, parent_uuid: str, vertices: Any, faces: Any, originals: Any
    ) -> None:
        """
        Args:
            uuid, parent_uuid: identities.
            vertices: (V, 3) meters; the last C are copies.
            faces: (F, 3) vertex indices.
            originals: (C,) whole numbers, see copies_fault().
        Raises:
            ValueError: what is wrong with the copies, or the arrays.
        """
        vertices, faces, originals = as_vertices(vertices), as_faces(faces), np.asarray(originals)
        fault = copies_fault(vertices, originals)
        if fault is not None:
            raise ValueError(fault)
        super().__init__(
            uuid,
            parent_uuid,
            vertices,
            faces,
            face_parents=np.arange(len(faces), dtype=np.uint32),
            vertex_parents=original_vertices(len(vertices), originals)[:, None],
            vertex_weights=np.ones((len(vertices), 1)),
            parent_vertex_count=len(vertices) - len(originals),
            parent_face_count=len(faces),
        )
        self.originals = self.vertex_parents[self.parent_vertex_count :, 0]
        self._order = np.argsort(self.originals, kind="stable")
        self._sorted = self.originals[self._order]

    @property
    def parent_vertices(self) -> np.ndarray:
        """(V_parent, 3) float32, read-only."""
        return self.vertices[: self.parent_vertex_count]

    @property
    def parent_faces(self) -> np.ndarray:
        """(F, 3) uint32: the faces with originals for copies."""
        return self.vertex_parents[:, 0][self.faces]

    def vertex_values(self, values: Any) -> np.ndarray:
        """(V,) or (V, C) of any dtype: copies have the value of their original.

        Raises:
            ValueError: another number of values.
        """
        values = np.asarray(values)
        if values.ndim not in (1, 2) or len(values) != self.parent_vertex_count:
            text = "values of the shape %s are not those of %d vertices of the parent"
            raise ValueError(text % (values.shape, self.parent_vertex_count))
        return np.concatenate([values, values[self.originals]])

    def with_copies(self, vertices: Any) -> Tuple[np.ndarray, np.ndarray]:
        """(N,) uint32: these vertices of the parent (K,), and then all their copies; (N,) int64:
        which of the K each of them is.
        """
        wanted = np.asarray(vertices, np.uint32)
        starts = np.searchsorted(self._sorted, wanted, "left")
        counts = np.searchsorted(self._sorted, wanted, "right") - starts
        places = np.arange(counts.sum()) + np.repeat(starts - np.cumsum(counts) + counts, counts)
        copies = self.parent_vertex_count + self._order[places]
        rows = np.arange(len(wanted))
        return (
            np.concatenate([wanted, copies.astype(np.uint32)]),
            np.concatenate([rows, np.repeat(rows, counts)]),
        )

    def parent_vertex_values(self, values: Any) -> np.ndarray:
        """See DerivedMesh: where copies have other values, the largest counts, and NaN before it,
        so that what is closed on one side of a seam is closed.

        Raises:
            ValueError: another number of values.
        """
        values = np.asarray(values)
        if values.ndim not in (1, 2) or len(values) != len(self.vertices):
            text = "values of the shape %s are not those of %d vertices"
            raise ValueError(text % (values.shape, len(self.vertices)))
        found = values[: self.parent_vertex_count].copy()
        np.maximum.at(found, self.originals, values[self.parent_vertex_count :])
        return found
