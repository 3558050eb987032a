"""Distances from obstacles, by other means than a front: brute force in NumPy, and fine graphs."""

import itertools

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra


def faces_edges(faces):
    """(E, 2) unique edges of faces, without those from a vertex to itself."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), 1)
    return np.unique(edges[edges[:, 0] != edges[:, 1]], axis=0)


def euclidean(vertices, faces, lethal):
    """(V,) Euclidean distances from lethal vertices and edges between two, in double precision.

    On a plane without holes and with a convex outline, this is the distance along the surface: who
    is not in a face between three comes to it over one of its edges.
    """
    points = vertices.astype(np.float64)
    best = np.full(len(points), np.inf)
    for v in np.flatnonzero(lethal):
        best = np.minimum(best, np.linalg.norm(points - points[v], axis=1))
    edges = faces_edges(faces)
    for a, b in edges[lethal[edges].all(1)]:
        side = points[b] - points[a]
        t = np.clip((points - points[a]) @ side / max(side @ side, 1e-300), 0, 1)
        best = np.minimum(best, np.linalg.norm(points - points[a] - t[:, None] * side, axis=1))
    return best


def fine_graph(vertices, faces, lethal, pieces=8):
    """(V,) distances over straight lines across faces between points that divide their edges.

    Never below the distance along the surface, and close above it.
    """
    points = [vertices.astype(np.float64)]
    sources = [np.flatnonzero(lethal)]
    count = len(vertices)
    edges = faces_edges(faces)
    on_edge = {}
    for a, b in edges:
        t = np.arange(1, pieces)[:, None] / pieces
        points.append(points[0][a] * (1 - t) + points[0][b] * t)
        on_edge[a, b] = np.arange(count, count + pieces - 1)
        if lethal[a] and lethal[b]:
            sources.append(on_edge[a, b])
        count += pieces - 1
    points = np.concatenate(points)
    rows, columns = [edges[:, 0]], [edges[:, 1]]
    for face in faces:
        groups = [np.array([v]) for v in face]
        pairs = [tuple(sorted(pair)) for pair in itertools.combinations(set(face.tolist()), 2)]
        groups += [on_edge[pair] for pair in pairs]
        everything = np.concatenate(groups)
        i, j = np.triu_indices(len(everything), 1)
        rows.append(everything[i])
        columns.append(everything[j])
    rows, columns = np.concatenate(rows), np.concatenate(columns)
    keep = rows != columns
    pairs = np.unique(np.sort(np.stack([rows[keep], columns[keep]], 1), 1), axis=0)
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    graph = coo_matrix((np.maximum(lengths, 1e-30), pairs.T), (count, count)).tocsr()
    sources = np.concatenate(sources)
    if not len(sources):
        return np.full(len(vertices), np.inf)
    field = dijkstra(graph, directed=False, indices=sources, min_only=True)
    return field[: len(vertices)]


def faded(distances, *, r, big_r, lethal_value, inscribed_value, scaling=None):
    """The sheet's formula without its square root, in double precision, one distance at a time."""
    costs = []
    for d in np.asarray(distances, np.float64):
        if d == 0:
            costs.append(np.inf if lethal_value < 0 else lethal_value)
        elif d <= r:
            costs.append(inscribed_value)
        elif d > big_r:
            costs.append(0.0)
        elif scaling is None:
            costs.append(inscribed_value * (np.cos(np.pi * (d - r) / (big_r - r)) + 1) / 2)
        else:
            costs.append(inscribed_value * np.exp(-scaling * (d - r)))
    return np.array(costs)
