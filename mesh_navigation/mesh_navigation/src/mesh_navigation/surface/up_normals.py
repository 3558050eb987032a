"""Surface normals that point up, whichever way the mesh is wound."""

from typing import Tuple

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.topology import Topology

# Below this share of the faces' area a sum of normals says nothing: they contradict each other.
_CONTRADICTION = 0.05


def faces_around(topology: Topology, vertices: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """(M,) faces around the first vertex, then those around the second and so on.

    And (M,) int64 indices into ``vertices`` that say around which.
    """
    vertices = np.asarray(vertices, dtype=np.int64)
    starts = topology.vertex_face_offsets[vertices].astype(np.int64)
    counts = topology.vertex_face_offsets[vertices + 1] - starts
    owners = np.repeat(np.arange(len(vertices)), counts)
    places = np.arange(len(owners)) + np.repeat(starts - np.cumsum(counts) + counts, counts)
    return topology.vertex_faces[places], owners


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


def vertex_up_normals(geometry: MeshGeometry, vertices: np.ndarray) -> np.ndarray:
    """(N,3) float32 unit normals that point up, at the vertices with these indices (N,).

    (0,0,1) at vertices without a face of any area. Weighted by area. Where faces around a vertex
    are wound against each other, so that their normals cancel out, each is turned up before it is
    added.
    """
    faces, owners = faces_around(geometry.topology, vertices)
    areas = area_vectors(geometry.vertices, geometry.faces[faces])
    as_wound = _sums(areas, owners, len(vertices))
    each_up = _sums(turned_up(areas), owners, len(vertices))
    total = _sums(np.linalg.norm(areas, axis=1, keepdims=True), owners, len(vertices))
    consistent = np.linalg.norm(as_wound, axis=1, keepdims=True) > _CONTRADICTION * total
    sums = np.where(consistent, turned_up(as_wound), each_up)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    # An isolated vertex has no surface and counts as level ground.
    usable = lengths > np.finfo(np.float64).tiny
    normals = np.where(usable, sums / np.where(usable, lengths, 1.0), [0.0, 0.0, 1.0])
    return normals.astype(np.float32)


def face_up_normals(geometry: MeshGeometry, faces: np.ndarray) -> np.ndarray:
    """(N,3) float64 unit normals that point up, of the faces with these indices (N,).

    Of a face without area: that of its first corner.
    """
    corners = geometry.faces[faces]
    areas = area_vectors(geometry.vertices, corners)
    lengths = np.linalg.norm(areas, axis=1)
    flat = lengths < np.finfo(np.float32).tiny
    normals = turned_up(areas) / np.where(flat, 1.0, lengths)[:, None]
    if flat.any():
        normals[flat] = vertex_up_normals(geometry, corners[flat, 0])
    return normals


def _sums(values: np.ndarray, owners: np.ndarray, count: int) -> np.ndarray:
    """(count,K) sums over the rows of (M,K) values that belong to each owner."""
    columns = [np.bincount(owners, weights=column, minlength=count) for column in values.T]
    return np.stack(columns, axis=1)
