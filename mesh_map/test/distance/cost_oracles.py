"""Weighted distances by other means than a front: fine graphs, and straight lines across strips."""

import itertools

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra


def fine_graph_potential(mesh, source, slowness=None, pieces=4):
    """(V,) float64 distances over straight lines across faces between points that divide edges.

    What a meter takes is linear between vertices; faces with a closed corner (+inf or NaN) cannot
    be crossed, but their sides between two open corners can be followed. The distances are never
    below those of the surface with such costs, and close above them.
    """
    count = len(mesh.vertices)
    if slowness is None:
        slowness = np.ones(count)
    slowness = np.asarray(slowness, np.float64)
    closed = ~np.isfinite(slowness)
    faces = mesh.faces.astype(np.int64)
    number = closed[faces].sum(axis=1)
    sides = faces[number == 1]
    sides = sides[~closed[sides]].reshape(-1, 2)
    faces = faces[number == 0]
    known = np.column_stack([mesh.vertices.astype(np.float64), np.where(closed, 0.0, slowness)])
    points, members = _divided(known, faces, pieces)
    first, second = np.triu_indices(members.shape[1], 1)
    rows, columns = members[:, first].ravel(), members[:, second].ravel()
    rows, columns = np.concatenate([rows, sides[:, 0]]), np.concatenate([columns, sides[:, 1]])
    keys = np.minimum(rows, columns) * len(points) + np.maximum(rows, columns)
    rows, columns = np.divmod(np.unique(keys[rows != columns]), len(points))
    offsets = points[rows, :3] - points[columns, :3]
    weights = np.linalg.norm(offsets, axis=1) * (points[rows, 3] + points[columns, 3]) / 2
    weights = np.maximum(weights, 1e-300)  # SciPy takes 0 for no edge
    graph = csr_matrix((weights, (rows, columns)), (len(points), len(points)))
    return dijkstra(graph, directed=False, indices=source)[:count]


def _divided(points, faces, pieces):
    """Rows of vertices and between them on edges, and (F, 3 pieces) those around each face."""
    ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, inverse = np.unique(ends, axis=0, return_inverse=True)
    parts = [points]
    for part in range(1, pieces):
        share = part / pieces
        parts.append(points[edges[:, 0]] * (1 - share) + points[edges[:, 1]] * share)
    on_edge = np.arange(len(edges) * (pieces - 1)).reshape(pieces - 1, len(edges)).T + len(points)
    inner = on_edge[inverse.ravel()].reshape(len(faces), 3 * (pieces - 1))
    return np.concatenate(parts), np.concatenate([faces, inner], axis=1)


def edge_graph_potential(mesh, source):
    """(V,) float64 distances along edges."""
    return fine_graph_potential(mesh, source, pieces=1)


def hops(mesh, source):
    """(V,) the number of edges to each vertex."""
    pairs = np.array(list(itertools.permutations(range(3), 2)))
    rows, columns = (mesh.faces[:, pairs[:, k]].ravel().astype(np.int64) for k in range(2))
    shape = (len(mesh.vertices),) * 2
    graph = csr_matrix((np.ones(len(rows)), (rows, columns)), shape)
    return dijkstra(graph, unweighted=True, indices=source)


def refracted(start, end, strips):
    """The least time from start to end, and where the way crosses each border of strips.

    Args:
        start, end: (x, y), start in the first strip and end in the last.
        strips: pairs (x of the right border, slowness) from left to right; the last one's is +inf.
    Returns:
        The time, and (N - 1,) y where the way crosses the borders between.

    In all strips the sine of the angle from the x axis times the slowness is the same (Snell's
    law); that number is found by bisection.
    """
    borders = [start[0]] + [right for right, _ in strips[:-1]] + [end[0]]
    widths = np.diff(borders)
    slowness = np.array([slow for _, slow in strips])
    height = end[1] - start[1]

    def rises(invariant):
        sine = invariant / slowness
        return widths * sine / np.sqrt(1.0 - sine * sine)

    low, high = 0.0, slowness.min() * (1 - 1e-12)
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if rises(middle).sum() < abs(height) else (low, middle)
    steps = rises(low) * np.sign(height)
    time = (np.hypot(widths, steps) * slowness).sum()
    return time, start[1] + np.cumsum(steps)[:-1]
