"""How the faces of a mesh hang together, as findings; NumPy and SciPy only."""
from typing import Iterator

import numpy as np

from mesh_msgs_hdf5.formats.base.edges import edges_of
from mesh_msgs_hdf5.formats.base.equal_rows import is_repeated
from mesh_msgs_hdf5.validation.findings import NOTE, WARNING, MapFinding


def check_topology(vertex_count: int, faces: np.ndarray) -> Iterator[MapFinding]:
    """Findings about faces (F, 3), each index below vertex_count."""
    repeated = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    yield from found("repeated_vertex", "faces", "faces name a vertex twice", repeated)
    again = is_repeated(np.sort(faces, axis=1).T)
    yield from found("duplicate_faces", "faces", "faces have the vertices of an earlier one", again)
    used = np.zeros(vertex_count, dtype=bool)
    used[faces.ravel()] = True
    yield from found("isolated_vertices", "vertices", "vertices belong to no face", ~used)
    kept = np.flatnonzero(~repeated)
    if len(kept):
        edges = edges_of(faces, kept)
        yield from _edge_findings(edges)
        yield from _fan_findings(edges, faces, kept, vertex_count)
        yield from _component_findings(edges, used, vertex_count)


def found(rule, where, message, bad, level=WARNING) -> Iterator[MapFinding]:
    """A finding if any of bad (N,) is set."""
    if bad.any():
        yield MapFinding(rule, level, where, message, int(bad.argmax()), int(np.count_nonzero(bad)))


def _edge_findings(edges):
    for rule, bad, text, level in (
        ("nonmanifold_edges", edges.count > 2, "edges belong to more than two faces", WARNING),
        ("boundary", edges.count == 1, "edges belong to one face only", NOTE),
    ):
        yield from _at_edges(rule, bad, text, level, edges)
    pair = edges.start[edges.count == 2]
    against = np.zeros(len(edges.start), dtype=bool)
    against[edges.count == 2] = edges.forward[pair] == edges.forward[pair + 1]
    text = "edges have two faces that are oriented against each other"
    yield from _at_edges("flipped_neighbors", against, text, WARNING, edges)


def _at_edges(rule, bad, text, level, edges):
    if bad.any():
        # the face that comes first in the mesh, and the vertices of that edge
        first = np.flatnonzero(bad)
        first = edges.start[first[edges.side[edges.start[first]].argmin()]]
        where = "%s, such as %d-%d of that face" % (text, edges.low[first], edges.high[first])
        number = int(np.count_nonzero(bad))
        yield MapFinding(rule, level, "faces", where, int(edges.side[first] // 3), number)


def _fan_findings(edges, faces, kept, vertex_count):
    """Corners at a vertex hang together across the edges there; more than one bunch is no fan."""
    inner = np.ones(len(edges.side), dtype=bool)
    inner[edges.start] = False
    after = np.flatnonzero(inner)
    ends = []
    for at in (after - 1, after):
        face, number = edges.side[at] // 3, edges.side[at] % 3
        following = 3 * face + (number + 1) % 3
        low = np.where(edges.forward[at], edges.side[at], following)
        high = np.where(edges.forward[at], following, edges.side[at])
        ends.append(np.concatenate([low, high]))
    bunches, bunch = _components(ends[0], ends[1], 3 * len(faces))
    vertex_of = np.full(bunches, -1, dtype=np.int64)
    corners = (3 * kept[:, None] + np.arange(3)).ravel()
    vertex_of[bunch[corners]] = faces[kept].ravel()
    fans = np.bincount(vertex_of[vertex_of >= 0], minlength=vertex_count)
    text = "vertices join faces that have no edge there in common"
    yield from found("nonmanifold_vertices", "vertices", text, fans > 1)


def _component_findings(edges, used, vertex_count):
    _, label = _components(edges.low[edges.start], edges.high[edges.start], vertex_count)
    sizes = np.bincount(label[used])
    sizes = sizes[sizes > 0]
    if len(sizes) > 1:
        text = "parts of the surface, not connected; the largest has %d of %d vertices" % (
            sizes.max(),
            sizes.sum(),
        )
        yield MapFinding("components", WARNING, "faces", text, None, len(sizes))


def _components(a, b, count):
    from scipy.sparse import coo_matrix  # only here: nodes need not load it
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(a), dtype=np.int8)
    return connected_components(coo_matrix((ones, (a, b)), (count, count)), directed=False)
