"""Directions to the goal from the ways that Dijkstra's algorithm finds."""

import numpy as np

from mesh_navigation.up_normals import area_vectors


def edge_directions(vertices: np.ndarray, predecessors: np.ndarray) -> np.ndarray:
    """(V,3) float32 unit vectors to the next vertex; zero where that is the vertex itself.

    Args:
        vertices: (V,3) m.
        predecessors: (V,) the next vertex on the way to the goal.
    """
    moving = np.flatnonzero(predecessors != np.arange(len(vertices)))
    steps = vertices[predecessors[moving]] - vertices[moving]
    directions = np.zeros((len(vertices), 3), dtype=np.float32)
    directions[moving] = _units(steps)
    return directions


def face_means(vertices: np.ndarray, faces: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """(F,3) float32 unit vectors: in the plane of each face, the mean of those at its corners.

    Zero where there is none at any corner, and where the corners contradict each other.

    Args:
        vertices: (V,3) m.
        faces: (F,3).
        directions: (V,3) unit vectors or zeros.
    """
    means = np.zeros((len(faces), 3), dtype=np.float32)
    used = np.flatnonzero(directions.any(axis=1)[faces].any(axis=1))
    corners = faces[used]
    normals = _units(area_vectors(vertices, corners))
    sums = directions[corners].sum(axis=1, dtype=np.float64)
    along = sums - np.sum(sums * normals, axis=1, keepdims=True) * normals
    usable = np.linalg.norm(along, axis=1) > 1e-3
    means[used[usable]] = _units(along[usable])
    return means


def _units(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1)
