"""Surface normals that point up, whichever way the mesh is wound."""

import numpy as np

# Below this share of the faces' area a sum of normals says nothing: they contradict each other.
_CONTRADICTION = 0.05


def turned_up(normals: np.ndarray) -> np.ndarray:
    """(N,3) normals, those with negative z turned round.

    On a wall (z = 0) y, then x decide, so that a normal and its opposite give the same result.
    """
    x, y, z = normals[:, 0], normals[:, 1], normals[:, 2]
    down = (z < 0) | ((z == 0) & ((y < 0) | ((y == 0) & (x < 0))))
    return np.where(down[:, None], -normals, normals)


def area_vectors(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,3) float64 cross products of the faces' edges: length is twice the area (m^2)."""
    a, b, c = (vertices[faces[:, corner]].astype(np.float64) for corner in range(3))
    return np.cross(b - a, c - a)


def vertex_up_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(V,3) float32 unit normals that point up; (0,0,1) at vertices without a face of any area.

    Weighted by area. Where faces around a vertex are wound against each other, so that their
    normals cancel out, each is turned up before it is added.
    """
    areas = area_vectors(vertices, faces)
    as_wound = _sum_at_corners(areas, faces, len(vertices))
    each_up = _sum_at_corners(turned_up(areas), faces, len(vertices))
    total = _sum_at_corners(np.linalg.norm(areas, axis=1, keepdims=True), faces, len(vertices))
    consistent = np.linalg.norm(as_wound, axis=1, keepdims=True) > _CONTRADICTION * total
    sums = np.where(consistent, turned_up(as_wound), each_up)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    # An isolated vertex has no surface and counts as level ground.
    usable = lengths > np.finfo(np.float64).tiny
    normals = np.where(usable, sums / np.where(usable, lengths, 1.0), [0.0, 0.0, 1.0])
    return normals.astype(np.float32)


def _sum_at_corners(values: np.ndarray, faces: np.ndarray, vertex_count: int) -> np.ndarray:
    """(V,K) sums over the faces of each vertex of (F,K) values."""
    corners = faces.ravel()
    columns = [
        np.bincount(corners, weights=np.repeat(column, 3), minlength=vertex_count)
        for column in values.T
    ]
    return np.stack(columns, axis=1)
