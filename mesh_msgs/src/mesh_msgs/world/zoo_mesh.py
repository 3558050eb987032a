"""What a generated mesh is, and what its traits mean."""

from typing import Dict, FrozenSet, NamedTuple, Optional, Tuple

import numpy as np

# Each trait is a statement about the mesh that is true if, and only if, the trait is listed.
TRAITS = {
    "empty": "there are no vertices and no faces",
    "closed": "there are faces, and no edge belongs to one face only",
    "boundary": "some edge belongs to one face only",
    "manifold": "at most two faces meet at an edge, and the faces at a vertex form a single fan",
    "oriented": "no two faces run through an edge in the same direction",
    "orientable": "flipping faces could make it oriented",
    "connected": "edges lead from every vertex to every other one",
    "planar": "all vertices lie in one plane",
    "upward": "there are faces, and the normal of each points up (z > 0)",
    "multi_level": "some vertical line crosses two faces that both look up, one above the other",
    "degenerate": "some face is thinner than 1/1000 of its longest edge, or names a vertex twice",
    "isolated_vertices": "some vertex belongs to no face",
    "duplicate_vertices": "two vertices have the same position",
    "duplicate_faces": "two faces have the same three vertices",
    "far": "the whole mesh is more than 100 km from the origin",
}


class ZooMesh(NamedTuple):
    """A generated mesh; lengths in meters, z up."""

    name: str
    # (V, 3) float32
    vertices: np.ndarray
    # (F, 3) uint32, counter-clockwise seen from outside (or from above)
    faces: np.ndarray
    # Names from TRAITS.
    traits: FrozenSet[str]
    # (V, 3) uint8 RGB, or None
    colors: Optional[np.ndarray] = None
    # Named points (x, y, z); each is a vertex of the mesh.
    places: Dict[str, Tuple[float, float, float]] = {}


def zoo_mesh(name: str, vertices: object, faces: object, traits: str) -> ZooMesh:
    """Build a ZooMesh from anything array-like; `traits` are separated by blanks."""
    return ZooMesh(
        name,
        np.asarray(vertices, dtype=np.float32).reshape(-1, 3),
        np.asarray(faces, dtype=np.uint32).reshape(-1, 3),
        frozenset(traits.split()),
    )


def grid_faces(index: np.ndarray, flip: Optional[np.ndarray] = None) -> np.ndarray:
    """Return two triangles per cell of an (N, M) array of vertex indices, as (2 (N-1) (M-1), 3) of
    its dtype.

    Counter-clockwise where the first axis is x and the second is y. The diagonal starts at the
    cell's first corner, except where `flip` (N-1, M-1), if given, is True.
    """
    a, b = index[:-1, :-1].ravel(), index[1:, :-1].ravel()
    c, d = index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    lower = np.stack([a, b, c], axis=1)
    upper = np.stack([a, c, d], axis=1)
    if flip is not None:
        other = np.asarray(flip, dtype=bool).ravel()
        lower[other, 2] = d[other]
        upper[other, 0] = b[other]
    return np.stack([lower, upper], axis=1).reshape(-1, 3)


def icosphere(subdivisions: int) -> Tuple[np.ndarray, np.ndarray]:
    """Return vertices (V, 3) float64 on the unit sphere and faces (20 * 4**subdivisions, 3)."""
    g = (1.0 + np.sqrt(5.0)) / 2.0
    points = [[0, a, b * g] for a in (-1, 1) for b in (-1, 1)]
    points += [[a, b * g, 0] for a in (-1, 1) for b in (-1, 1)]
    points += [[b * g, 0, a] for a in (-1, 1) for b in (-1, 1)]
    vertices = np.array(points, dtype=np.float64)
    # The faces of the icosahedron are the 20 triples whose vertices are 2 (the edge length) apart.
    near = np.isclose(np.linalg.norm(vertices[:, None] - vertices[None], axis=2), 2.0)
    triples = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    faces = np.array(triples)
    inward = np.linalg.det(vertices[faces]) < 0.0
    faces[inward] = faces[inward][:, [0, 2, 1]]
    for _ in range(subdivisions):
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, where = np.unique(edges, axis=0, return_inverse=True)
        a, b, c = faces.T
        ab, bc, ca = (len(vertices) + where.reshape(-1, 3)).T
        vertices = np.concatenate([vertices, vertices[unique].mean(axis=1)])
        corners = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        faces = np.concatenate([np.stack(corner, axis=1) for corner in corners])
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces
