"""What is around a vertex or face."""

from typing import Callable, Optional

import numpy as np

from mesh_map.query_arguments import number
from mesh_map.topology import NO_EDGE, Topology

Inside = Callable[[np.ndarray], np.ndarray]


class Neighborhoods:
    """The neighborhoods of mesh_map.queries.SurfaceQueries.

    All return indices, (N,) uint32, ascending. Arguments that are no index raise IndexError.
    """

    topology: Topology
    vertices: np.ndarray
    faces: np.ndarray

    def neighbors_of_vertex(self, vertex: int) -> np.ndarray:
        """The vertices that an edge connects with this one."""
        return self.topology.neighbors_of(_index(vertex, self.topology.vertex_count, "vertex"))

    def faces_of_vertex(self, vertex: int) -> np.ndarray:
        """The faces around a vertex: its ring."""
        return self.topology.faces_of(_index(vertex, self.topology.vertex_count, "vertex"))

    def faces_of_edge(self, edge: int) -> np.ndarray:
        """The faces that meet in an edge, degenerate ones excepted."""
        edge = _index(edge, self.topology.edge_count, "edge")
        offsets = self.topology.edge_face_offsets
        return self.topology.edge_faces[offsets[edge] : offsets[edge + 1]]

    def neighbors_of_face(self, face: int) -> np.ndarray:
        """The faces that share an edge with this one: all of them, also where more than two meet,
        duplicates included. A degenerate face has none.
        """
        face = _index(face, self.topology.face_count, "face")
        edges = self.topology.face_edges[face]
        if NO_EDGE in edges:
            return np.zeros(0, np.uint32)
        rows = [self.faces_of_edge(edge) for edge in edges]
        return _without(np.unique(np.concatenate(rows)), face)

    def ring_of_face(self, face: int) -> np.ndarray:
        """The faces that share a vertex with this one."""
        face = _index(face, self.topology.face_count, "face")
        rows = [self.topology.faces_of(vertex) for vertex in self.faces[face]]
        return _without(np.unique(np.concatenate(rows)), face)

    def k_ring(self, vertex: int, k: int) -> np.ndarray:
        """The vertices that at most k edges connect with this one, which is among them."""
        if not isinstance(k, (int, np.integer)) or k < 0:
            raise ValueError("k has to be a whole number, 0 or more, not %r" % (k,))
        return self._grown(vertex, int(k), None)

    def radius_neighborhood(self, vertex: int, radius: float) -> np.ndarray:
        """The vertices that are reached from this one over edges through vertices that are all
        nearer to it than the radius (meters, Euclidean); it is among them. What the layers call the
        neighborhood of a vertex.
        """
        reach = number(radius, "radius")
        if not reach > 0.0:
            raise ValueError("the radius has to be above 0, not %g" % reach)
        vertex = _index(vertex, self.topology.vertex_count, "vertex")
        center = self.vertices[vertex].astype(np.float64)

        def is_inside(others: np.ndarray) -> np.ndarray:
            gaps = self.vertices[others] - center
            return (gaps[:, 0] ** 2 + gaps[:, 1] ** 2) + gaps[:, 2] ** 2 < reach * reach

        return self._grown(vertex, self.topology.vertex_count, is_inside)

    def _grown(self, vertex: int, rings: int, is_inside: Optional[Inside]) -> np.ndarray:
        """Ring by ring, through vertices that are inside."""
        count = self.topology.vertex_count
        newest = np.array([_index(vertex, count, "vertex")], np.uint32)
        seen = np.zeros(count, np.bool_)
        seen[newest] = True
        found = [newest]
        offsets, neighbors = self.topology.neighbor_offsets, self.topology.neighbors
        for _ in range(rings):
            begins = offsets[newest].astype(np.int64)
            lengths = offsets[newest + 1] - begins
            shifts = np.repeat(begins - (np.cumsum(lengths) - lengths), lengths)
            newest = np.unique(neighbors[np.arange(len(shifts)) + shifts])
            newest = newest[~seen[newest]]
            seen[newest] = True
            if is_inside is not None:
                newest = newest[is_inside(newest)]
            if not len(newest):
                break
            found.append(newest)
        return np.sort(np.concatenate(found))


def _index(value: int, count: int, name: str) -> int:
    if not isinstance(value, (int, np.integer)) or not 0 <= value < count:
        raise IndexError("there is no %s %r: there are %d" % (name, value, count))
    return int(value)


def _without(indices: np.ndarray, own: int) -> np.ndarray:
    return indices[indices != own].astype(np.uint32)
