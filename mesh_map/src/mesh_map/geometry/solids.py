"""Closed surfaces of a mesh: what is solid, as a wall or a box of its own is in CAD and BIM."""

from typing import NamedTuple, Optional, Tuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.topology import Topology

NO_SOLID = int(_kernels._NO_INDEX)
# Meters that rounding may put corners apart: at least, and at most, however large coordinates are.
_ROUNDING = 1e-4, 1e-3
_MOST_COPIES = 8  # of a face that are told apart


class Solids(NamedTuple):
    """The solids of a mesh, and the mesh in which borders that lie on each other are joined.

    Many formats have vertices of their own for each side of a box, or for each face, some rounded
    differently. So vertices at borders that are at the same place, or within a tenth of a
    millimeter (a millimeter, where coordinates are as coarse as that), count as one here.

    Attributes:
        numbers: (F,) uint32, of each face that of its solid; NO_SOLID for faces of none. A solid is
            a patch of faces that are joined at edges, all edges of which have an even number of
            them, so that a line to far away crosses it an odd number of times from inside. Of faces
            with the same corners one counts, or, where it would leave the patch open, none (what
            two boxes have in common, also where faces of theirs are doubled).
        joined: (V,) uint32, for each vertex the one that stands for it: of those at borders at the
            same place the lowest, else itself.
        faces: (F, 3) uint32, of these vertices.
        vertex_face_offsets, vertex_faces: as of Topology, of these faces.
    """

    numbers: np.ndarray
    joined: np.ndarray
    faces: np.ndarray
    vertex_face_offsets: np.ndarray
    vertex_faces: np.ndarray


def find_solids(geometry: MeshGeometry) -> Solids:
    """The solids of a mesh, found once for a geometry."""
    return geometry.made(_find)


def _find(geometry: MeshGeometry) -> Solids:
    topology, faces = geometry.topology, geometry.faces
    numbers = _numbers(faces, topology)
    joined = np.arange(len(geometry.vertices), dtype=np.uint32)
    for join in (_same_places, _near_places):
        more = join(geometry.vertices, np.unique(topology.edges[topology.border_edges]))
        if more is not None:
            joined = more[joined]
            faces = joined[geometry.faces]
            topology = Topology(faces=faces, vertex_count=len(joined))
            numbers = _added(numbers, _numbers(faces, topology))
    rows = topology.vertex_face_offsets, topology.vertex_faces
    return Solids(read_only(numbers), read_only(joined), read_only(faces), *rows)


def _numbers(faces: np.ndarray, topology: Topology) -> np.ndarray:
    """(F,) of each face that of its solid, see Solids."""
    first, copies = _copies(faces, topology)
    if (copies == 1).all():
        return _kernels._solids(topology.face_edges, topology.face_flags, topology.edge_count)
    some = np.flatnonzero(first)
    count = topology.vertex_count
    kept = some[_closing(Topology(faces=faces[some], vertex_count=count), copies[some])]
    part = Topology(faces=faces[kept], vertex_count=count)
    numbers = np.full(len(faces), NO_SOLID, np.uint32)
    numbers[kept] = _kernels._solids(part.face_edges, part.face_flags, part.edge_count)
    return numbers


def _copies(faces: np.ndarray, topology: Topology) -> Tuple[np.ndarray, np.ndarray]:
    """(F,) bool: the first of faces with the same corners; (F,) int64: their number."""
    first, copies = np.ones(len(faces), bool), np.ones(len(faces), np.int64)
    edges = topology.face_edges.reshape(-1, 3)
    proper = (edges < topology.edge_count).all(axis=1)
    counts = np.bincount(edges[proper].ravel(), minlength=topology.edge_count)
    crowded = np.flatnonzero(proper)[(counts[edges[proper]] > 2).all(axis=1)]
    if len(crowded):
        corners = np.ascontiguousarray(np.sort(faces[crowded], axis=1))
        _, at, inverse, sizes = np.unique(
            corners.view(np.dtype((np.void, 12))).ravel(),
            return_index=True,
            return_inverse=True,
            return_counts=True,
        )
        first[crowded] = False
        first[crowded[at]] = True
        copies[crowded] = sizes[inverse]
    return first, copies


def _closing(topology: Topology, copies: np.ndarray) -> np.ndarray:
    """(F,) bool: which faces count, so that edges have even numbers of them. Those that are there
    once do; then those with fewer copies before those with more, where they are needed: what two
    things have in common has the copies of both."""
    counts = copies == 1
    ranks = np.minimum(copies, _MOST_COPIES)
    for rank in np.unique(ranks[~counts]):
        counts |= _needed(topology, counts, ranks == rank, ranks > rank)
    return counts


def _needed(
    topology: Topology, counts: np.ndarray, some: np.ndarray, later: np.ndarray
) -> np.ndarray:
    """(F,) bool: those of some faces which edges need beside faces that count, where others are
    looked at later. Those side by side, with nothing that counts at the edge between them, are
    needed or not together, as most of their other edges say."""
    edges = topology.face_edges.reshape(-1, 3)
    proper = (edges < topology.edge_count).all(axis=1)
    others, open_faces = (
        np.bincount(edges[proper & which].ravel(), minlength=topology.edge_count)
        for which in (counts, some | later)
    )
    faces = np.repeat(np.flatnonzero(some), 3)
    at = edges[some].ravel()
    between = others[at] == 0
    ends = faces[between], len(edges) + at[between]
    size = len(edges) + topology.edge_count
    graph = coo_matrix((np.ones(len(ends[0]), bool), ends), shape=(size, size))
    patches = connected_components(graph, directed=False)[1]
    votes = np.where(open_faces[at] == 1, 1, 0)
    votes = np.where(between, 0, np.where(others[at] % 2 == 1, votes, -votes))
    needed = np.bincount(patches[faces], weights=votes, minlength=patches.max() + 1) >= 0
    return some & needed[patches[: len(edges)]]


def _added(numbers: np.ndarray, more: np.ndarray) -> np.ndarray:
    """Numbers of solids with those of others, which count where there is none yet."""
    found = numbers != NO_SOLID
    more = more.copy()
    more[more != NO_SOLID] += np.uint32(numbers[found].max(initial=0) + found.any())
    more = np.where(found, numbers, more)
    found = more != NO_SOLID
    more[found] = np.unique(more[found], return_inverse=True)[1]
    return more


def _same_places(vertices: np.ndarray, some: np.ndarray) -> Optional[np.ndarray]:
    """(V,) uint32 for each vertex the lowest of `some` at its place, else itself; None where it is
    itself for all."""
    places = np.ascontiguousarray(vertices[some] + np.float32(0))  # no -0
    _, first, inverse = np.unique(
        places.view(np.dtype((np.void, 12))).ravel(), return_index=True, return_inverse=True
    )
    return _as_table(len(vertices), some, some[first[inverse]]) if len(first) < len(some) else None


def _near_places(vertices: np.ndarray, some: np.ndarray) -> Optional[np.ndarray]:
    """The same of those that are nearer to each other than rounding may put them apart. Of a row of
    them that is longer than that, none."""
    places = vertices[some].astype(np.float64)
    near = np.clip(4.0 * np.spacing(np.abs(vertices[some]).max(axis=1)), *_ROUNDING)
    pairs = cKDTree(places).query_pairs(_ROUNDING[1], output_type="ndarray")
    gaps = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    pairs = pairs[gaps <= near[pairs].min(axis=1)]
    graph = coo_matrix((np.ones(len(pairs), bool), pairs.T), shape=(len(some), len(some)))
    groups = connected_components(graph, directed=False)[1]
    _, first = np.unique(groups, return_index=True)
    first = first[groups]
    far = np.linalg.norm(places - places[first], axis=1) > near[first]
    alone = np.bincount(groups, weights=far)[groups] > 0.0
    first = np.where(alone, np.arange(len(some)), first)
    return _as_table(len(vertices), some, some[first]) if len(pairs) and not alone.all() else None


def _as_table(count: int, some: np.ndarray, become: np.ndarray) -> np.ndarray:
    table = np.arange(count, dtype=np.uint32)
    table[some] = become
    return table
