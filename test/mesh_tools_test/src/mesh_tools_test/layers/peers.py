"""What others take for the same: NumPy, SciPy's cKDTree and Dijkstra, and numba where installed."""

from typing import Any, Callable, Optional, Tuple

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree


def numpy_edges(faces: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Unique edges (E, 2), and how many faces each has."""
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).astype(np.uint64)
    keys, counts = np.unique(sides[:, 0] << np.uint64(32) | sides[:, 1], return_counts=True)
    edges = np.stack([keys >> np.uint64(32), keys & np.uint64(0xFFFFFFFF)], axis=1)
    return edges.astype(np.uint32), counts


def numpy_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals of vertices, by those of faces and bincount, the fastest way in NumPy."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    corners, count = faces.ravel(), len(vertices)
    total = [np.bincount(corners, np.repeat(normals[:, k], 3), count) for k in range(3)]
    mean = np.stack(total, axis=1)
    return mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-30)


def numpy_mean_angles(normals: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Mean angle of each vertex to its neighbors."""
    cosine = np.einsum("ij,ij->i", normals[edges[:, 0]], normals[edges[:, 1]])
    angles = np.repeat(np.arccos(np.clip(cosine, -1.0, 1.0)), 2)
    number = np.bincount(edges.ravel(), minlength=len(normals))
    return np.bincount(edges.ravel(), angles, len(normals)) / np.maximum(number, 1)


def kdtree_statistics(
    vertices: np.ndarray, angles: np.ndarray, radius: float, share: int
) -> Tuple[np.ndarray, np.ndarray]:
    """Height difference and roughness of every share-th vertex, two threads.

    For roughness, the vertex itself does not count. By Euclidean distance alone: the tree knows no
    edges.
    """
    tree = cKDTree(vertices)
    rows = tree.query_ball_point(vertices[::share], radius, workers=2)
    counts = np.array([len(row) for row in rows])
    members = np.concatenate(rows).astype(np.int64)
    starts = np.cumsum(counts) - counts
    z = vertices[members, 2]
    height = np.maximum.reduceat(z, starts) - np.minimum.reduceat(z, starts)
    total = np.add.reduceat(angles[members], starts) - angles[::share]
    return height, total / np.maximum(counts - 1, 1)


def scipy_distances(topology: Any, lengths: np.ndarray, lethal: np.ndarray, limit: float) -> Any:
    """(V,) shortest ways along edges from lethal vertices up to a limit."""
    weights = lengths[topology.neighbor_edges].astype(np.float64)
    shape = (topology.vertex_count, topology.vertex_count)
    graph = csr_matrix((weights, topology.neighbors, topology.neighbor_offsets), shape)
    return dijkstra(graph, indices=np.flatnonzero(lethal), min_only=True, limit=limit)


def numpy_combination(layers: Any) -> np.ndarray:
    """Sum of factor times cost, lethal is +inf."""
    total = np.zeros(len(layers[0][0]))
    lethal = np.zeros(len(total), bool)
    for costs, dead, factor in layers:
        total += factor * costs
        lethal |= dead
    total[lethal] = np.inf
    return total.astype(np.float32)


def numba_statistics() -> Optional[Callable[..., Tuple[np.ndarray, np.ndarray]]]:
    """The same search over edges as in mesh_map, compiled by numba; None where it is absent.

    Called with vertices, offsets and neighbors of the topology, angles and radius; gives height
    difference and roughness (without the vertex itself).
    """
    try:
        import numba
    except ImportError:
        return None

    @numba.njit(parallel=True, nogil=True)
    def statistics(vertices, offsets, neighbors, angles, radius, parts):
        count = len(vertices)
        height, rough = np.zeros(count, np.float32), np.zeros(count, np.float32)
        square = radius * radius
        for part in numba.prange(parts):
            stamp = np.full(count, -1, np.int32)
            queue = np.zeros(count, np.int32)
            for v in range(part * count // parts, (part + 1) * count // parts):
                x, y, z = vertices[v, 0], vertices[v, 1], vertices[v, 2]
                low, high, total = z, z, 0.0
                stamp[v], queue[0], first, last = v, v, 0, 1
                while first < last:
                    u = queue[first]
                    first += 1
                    for k in range(offsets[u], offsets[u + 1]):
                        w = neighbors[k]
                        if stamp[w] == v:
                            continue
                        stamp[w] = v
                        dx, dy, dz = vertices[w, 0] - x, vertices[w, 1] - y, vertices[w, 2] - z
                        if dx * dx + dy * dy + dz * dz < square:
                            queue[last] = w
                            last += 1
                            low, high = min(low, vertices[w, 2]), max(high, vertices[w, 2])
                            total += angles[w]
                height[v] = high - low
                rough[v] = total / max(last - 1, 1)
        return height, rough

    return statistics
