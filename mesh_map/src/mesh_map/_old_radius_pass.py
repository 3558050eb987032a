"""TRANSITION: stand-in until everybody has built the kernels."""

import numpy as np

from mesh_map import _kernels


def compute(g, radius, wanted):
    t = g.topology
    result = {}
    if "height_difference" in wanted:
        result["height_difference"] = _kernels._height_difference(
            g.vertices, t.neighbor_offsets, t.neighbors, radius
        )
    if wanted <= {"height_difference"}:
        return result
    count = len(g.vertices)
    p = g.vertices.astype(np.float64)
    n = g.vertex_normals.astype(np.float64)
    a, b = t.edges[:, 0], t.edges[:, 1]
    angle = np.arccos(np.clip(np.einsum("ij,ij->i", n[a], n[b]), -1, 1))
    degree = np.bincount(t.edges.ravel(), minlength=count)
    mean = np.bincount(t.edges.ravel(), np.repeat(angle, 2), count) / np.maximum(degree, 1)
    offsets = t.neighbor_offsets.astype(np.int64)
    seen = front = np.arange(count, dtype=np.int64) * (count + 1)
    while len(front):
        center, at = front // count, front % count
        lengths = offsets[at + 1] - offsets[at]
        first = np.repeat(offsets[at] - np.cumsum(lengths) + lengths, lengths)
        to = t.neighbors[first + np.arange(lengths.sum())].astype(np.int64)
        center = np.repeat(center, lengths)
        near = ((p[to] - p[center]) ** 2).sum(1) < radius**2
        front = np.setdiff1d(center[near] * count + to[near], seen)
        seen = np.union1d(seen, front)
    center, around = seen // count, seen % count
    starts = np.flatnonzero(np.diff(center, prepend=-1))
    result["roughness"] = np.add.reduceat(mean[around], starts) / np.bincount(center)
    result["ridge"] = np.add.reduceat(
        np.linalg.norm(p[around] + n[around] - p[center] - n[center], axis=1), starts
    ) / np.maximum(np.bincount(center) - 1, 1)
    return {name: np.asarray(result[name], np.float32) for name in wanted}
