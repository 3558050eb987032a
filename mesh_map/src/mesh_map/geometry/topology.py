"""What is next to what in a triangle mesh."""

import re
from functools import cached_property
from typing import Any, Dict, Tuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only

NO_EDGE = int(_kernels._NO_INDEX)

# Bits of the flags that the kernel gives (topology.h).
_EDGE_BORDER, _EDGE_NON_MANIFOLD, _EDGE_INCONSISTENT = 1, 2, 4
_FACE_DEGENERATE, _FACE_DUPLICATE = 1, 2
_VERTEX_NON_MANIFOLD, _VERTEX_ISOLATED = 1, 2


class Topology:
    """Adjacency of any triangle soup.

    Nothing is repaired or left out; oddities are counted. Arrays are read-only.

    An edge is a pair of different vertices (a < b) that follow each other in some face. A
    degenerate face (one that names a vertex twice) has its edges too, but does not count as a face
    of them.

    Attributes:
        vertex_count, face_count, edge_count, component_count: numbers of each.
        edges: (E, 2) uint32, sorted, unique.
        face_edges: (F, 3) uint32; column k is the edge between corners k and k + 1; NO_EDGE where
            these are one vertex.
        edge_face_counts: (E,) uint32, number of (not degenerate) faces at each edge.
        neighbor_offsets: (V + 1,) uint32; the neighbors of v are
            neighbors[neighbor_offsets[v]:neighbor_offsets[v + 1]].
        neighbors: (2 E,) uint32 vertices, ascending for each vertex.
        neighbor_edges: (2 E,) uint32, the edges to them.
        vertex_face_offsets, vertex_faces: (V + 1,) and (N,) uint32, the faces around each vertex in
            the same form.
        edge_face_offsets, edge_faces: (E + 1,) and (N,) uint32, the (not degenerate) faces at each
            edge in the same form; made when they are first asked for.
        components: (V,) int32, connected over edges; numbered from 0 in the order of their lowest
            vertices.
        border_edges: (E,) bool, edges of one face.
        non_manifold_edges: (E,) bool, edges of more than two faces.
        inconsistent_edges: (E,) bool, edges of two faces that run through it in the same direction.
        non_manifold_vertices: (V,) bool, the faces around do not form one fan, or share a
            non-manifold edge.
        isolated_vertices: (V,) bool, vertices without an edge.
        degenerate_faces: (F,) bool, faces that name a vertex twice.
        duplicate_faces: (F,) bool, faces with the vertices of a face of lower index, in any order.
    """

    def __init__(self, *, faces: Any, vertex_count: int, threads: int = 0) -> None:
        """Builds everything at once; 2 M faces take a fraction of a second.

        Args:
            faces: (F, 3) whole numbers, vertex indices.
            vertex_count: V.
            threads: 0 for all cores.
        Raises:
            ValueError: a face that refers to no vertex (the first is named), or a wrong shape or
                dtype.
        """
        faces = as_faces(faces)
        if vertex_count < 0:
            raise ValueError("the number of vertices is negative")
        arrays = _kernels._topology(faces, vertex_count, threads)
        self.vertex_count = int(vertex_count)
        self.face_count = len(faces)
        self.component_count: int = arrays["component_count"]
        self.edges = read_only(arrays["edges"])
        self.edge_count = len(self.edges)
        self.face_edges = read_only(arrays["face_edges"])
        self.edge_face_counts = read_only(arrays["edge_face_counts"])
        self.neighbor_offsets = read_only(arrays["neighbor_offsets"])
        self.neighbors = read_only(arrays["neighbors"])
        self.neighbor_edges = read_only(arrays["neighbor_edges"])
        self.vertex_face_offsets = read_only(arrays["vertex_face_offsets"])
        self.vertex_faces = read_only(arrays["vertex_faces"])
        self.components = read_only(arrays["components"])
        self._edge_flags = arrays["edge_flags"]
        self._face_flags = arrays["face_flags"]
        self._vertex_flags = arrays["vertex_flags"]

    @property
    def border_edges(self) -> np.ndarray:
        return (self._edge_flags & _EDGE_BORDER) != 0

    @property
    def non_manifold_edges(self) -> np.ndarray:
        return (self._edge_flags & _EDGE_NON_MANIFOLD) != 0

    @property
    def inconsistent_edges(self) -> np.ndarray:
        return (self._edge_flags & _EDGE_INCONSISTENT) != 0

    @property
    def non_manifold_vertices(self) -> np.ndarray:
        return (self._vertex_flags & _VERTEX_NON_MANIFOLD) != 0

    @property
    def isolated_vertices(self) -> np.ndarray:
        return (self._vertex_flags & _VERTEX_ISOLATED) != 0

    @property
    def degenerate_faces(self) -> np.ndarray:
        return (self._face_flags & _FACE_DEGENERATE) != 0

    @property
    def duplicate_faces(self) -> np.ndarray:
        return (self._face_flags & _FACE_DUPLICATE) != 0

    @cached_property
    def _edge_face_rows(self) -> Tuple[np.ndarray, np.ndarray]:
        offsets, faces = _kernels._edge_faces(self.face_edges, self.edge_count)
        return read_only(offsets), read_only(faces)

    @property
    def edge_face_offsets(self) -> np.ndarray:
        return self._edge_face_rows[0]

    @property
    def edge_faces(self) -> np.ndarray:
        return self._edge_face_rows[1]

    @property
    def edge_flags(self) -> np.ndarray:
        """(E,) uint8, the flags of edges in the form that kernels take (topology.h)."""
        return read_only(self._edge_flags)

    @property
    def face_flags(self) -> np.ndarray:
        """(F,) uint8, the flags of faces in the form that kernels take (topology.h)."""
        return read_only(self._face_flags)

    def neighbors_of(self, vertex: int) -> np.ndarray:
        """The vertices that an edge connects with this one, ascending."""
        return self.neighbors[self.neighbor_offsets[vertex] : self.neighbor_offsets[vertex + 1]]

    def faces_of(self, vertex: int) -> np.ndarray:
        """The faces around a vertex, ascending."""
        return self.vertex_faces[
            self.vertex_face_offsets[vertex] : self.vertex_face_offsets[vertex + 1]
        ]

    def counts(self) -> Dict[str, int]:
        """The numbers of everything, for programs."""
        return {
            "vertices": self.vertex_count,
            "faces": self.face_count,
            "edges": self.edge_count,
            "components": self.component_count,
            "border_edges": int(self.border_edges.sum()),
            "non_manifold_edges": int(self.non_manifold_edges.sum()),
            "non_manifold_vertices": int(self.non_manifold_vertices.sum()),
            "inconsistent_edges": int(self.inconsistent_edges.sum()),
            "duplicate_faces": int(self.duplicate_faces.sum()),
            "degenerate_faces": int(self.degenerate_faces.sum()),
            "isolated_vertices": int(self.isolated_vertices.sum()),
        }

    def report(self) -> str:
        """One line for people: sizes, and whichever oddities there are."""
        return ", ".join(
            quantity(count, name.replace("non_", "non-").replace("_", " "))
            for name, count in self.counts().items()
            if count or name in ("vertices", "faces", "edges", "components")
        )


def quantity(count: int, plural: str) -> str:
    """A number of things of a mesh for people, such as "1 face" or "2,416 faces"."""
    singular = re.sub(r"s\b", "", plural.replace("vertices", "vertexs"))
    return "%s %s" % (format(count, ","), singular if count == 1 else plural)


def edge_lengths(vertices: Any, edges: np.ndarray) -> np.ndarray:
    """Euclidean lengths of edges in meters, (E,) float32, computed in double precision.

    Args:
        vertices: (V, 3) meters.
        edges: (E, 2) uint32 vertex indices.
    Raises:
        ValueError: wrong shapes, or an edge that refers to no vertex.
    """
    return _kernels._edge_lengths(as_vertices(vertices), np.ascontiguousarray(edges, np.uint32))
