"""What is next to what in a triangle mesh."""

import re
from functools import cached_property
from typing import Any, Dict, Tuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only

NO_EDGE = int(_kernels._NO_INDEX)

_ARRAYS = ("edges", "face_edges", "edge_face_counts", "neighbor_offsets", "neighbors")
_ARRAYS += ("neighbor_edges", "vertex_face_offsets", "vertex_faces", "components")
_ARRAYS += ("edge_flags", "face_flags", "vertex_flags")
_ODDITIES = ("border_edges", "non_manifold_edges", "non_manifold_vertices", "inconsistent_edges")
_ODDITIES += ("duplicate_faces", "degenerate_faces", "isolated_vertices")


def _flag(flags: str, bit: int) -> property:
    """Where a bit of the flags that the kernel gives (topology.h) is set."""
    return property(lambda topology: (getattr(topology, flags) & bit) != 0)


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
        edge_flags, face_flags, vertex_flags: (E,), (F,) and (V,) uint8, what follows in the form
            that kernels take (topology.h).
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
        for name in _ARRAYS:
            setattr(self, name, read_only(arrays[name]))
        self.edge_count = len(self.edges)

    border_edges = _flag("edge_flags", 1)
    non_manifold_edges = _flag("edge_flags", 2)
    inconsistent_edges = _flag("edge_flags", 4)
    non_manifold_vertices = _flag("vertex_flags", 1)
    isolated_vertices = _flag("vertex_flags", 2)
    degenerate_faces = _flag("face_flags", 1)
    duplicate_faces = _flag("face_flags", 2)

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

    def neighbor_places(self, vertices: np.ndarray) -> np.ndarray:
        """Where those of some vertices, (K,) whole numbers, are in neighbors and neighbor_edges."""
        starts = self.neighbor_offsets[vertices].astype(np.int64)
        counts = self.neighbor_offsets[vertices + 1].astype(np.int64) - starts
        return np.arange(counts.sum()) + np.repeat(starts - np.cumsum(counts) + counts, counts)

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
        sizes = {
            "vertices": self.vertex_count,
            "faces": self.face_count,
            "edges": self.edge_count,
            "components": self.component_count,
        }
        return {**sizes, **{name: int(getattr(self, name).sum()) for name in _ODDITIES}}

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
