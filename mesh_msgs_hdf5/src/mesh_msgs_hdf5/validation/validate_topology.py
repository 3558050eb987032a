"""How the faces of a mesh hang together, as findings; the module _surface (C++) has the loops."""
from typing import Iterator

import numpy as np

from mesh_msgs_hdf5.validation.findings import NOTE, WARNING, MapFinding


def check_topology(vertex_count: int, faces: np.ndarray) -> Iterator[MapFinding]:
    """Findings about faces (F, 3), each index below vertex_count."""
    from mesh_msgs_hdf5 import _surface  # only here: nodes need not load it

    faces = np.ascontiguousarray(faces, np.uint32)
    repeated = has_repeated_vertex(faces)
    yield from found("repeated_vertex", "faces", "faces name a vertex twice", repeated)
    count, first = _surface._repeated_faces(faces, vertex_count)
    text = "faces have the vertices of an earlier one"
    yield from _counted("duplicate_faces", "faces", text, count, first)
    used = np.zeros(vertex_count, dtype=bool)
    used[faces.ravel()] = True
    yield from found("isolated_vertices", "vertices", "vertices belong to no face", ~used)
    if repeated.all():
        return
    many, border, against, split, parts = _surface._surface(faces, vertex_count)
    for rule, edges, text, level in (
        ("nonmanifold_edges", many, "edges belong to more than two faces", WARNING),
        ("boundary", border, "edges belong to one face only", NOTE),
        (
            "flipped_neighbors",
            against,
            "edges have two faces that are oriented against each other",
            WARNING,
        ),
    ):
        # the face that comes first in the mesh, and the vertices of that edge
        count, face, low, high = edges
        where = "%s, such as %d-%d of that face" % (text, low, high)
        yield from _counted(rule, "faces", where, count, face, level)
    text = "vertices join faces that have no edge there in common"
    yield from _counted("nonmanifold_vertices", "vertices", text, *split)
    count, largest, total = parts
    if count > 1:
        text = "parts of the surface, not connected; the largest has %d of %d vertices"
        yield MapFinding("components", WARNING, "faces", text % (largest, total), None, count)


def has_repeated_vertex(faces: np.ndarray) -> np.ndarray:
    """(F,): which faces (F, 3) name a vertex twice."""
    a, b, c = faces.T
    return (a == b) | (b == c) | (c == a)


def _counted(rule, where, message, count, first, level=WARNING) -> Iterator[MapFinding]:
    if count:
        yield MapFinding(rule, level, where, message, first, count)


def found(rule, where, message, bad, level=WARNING) -> Iterator[MapFinding]:
    """A finding if any of bad (N,) is set."""
    if bad.any():
        yield MapFinding(rule, level, where, message, int(bad.argmax()), int(np.count_nonzero(bad)))
