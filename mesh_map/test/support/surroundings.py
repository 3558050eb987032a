"""Plain Python for what is around vertices, to compare kernels with."""

from functools import lru_cache

import numpy as np
from mesh_map.geometry.topology import Topology


@lru_cache(maxsize=None)
def neighborhoods(mesh, radius):
    """N_r(v) without v, an array for each v: grown over edges through vertices nearer than r."""
    topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    points = mesh.vertices.astype(np.float64).tolist()
    next_to = [topology.neighbors_of(v).tolist() for v in range(len(points))]
    result = []
    for v, (x, y, z) in enumerate(points):
        seen, front, reached = {v}, [v], []
        while front:
            for u in next_to[front.pop()]:
                if u not in seen:
                    seen.add(u)
                    p = points[u]
                    if (p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2 < radius * radius:
                        front.append(u)
                        reached.append(u)
        result.append(np.array(reached, np.int64))
    return tuple(result)


def height_differences(mesh, around, up=(0, 0, 1), own=True):
    """Over each vertex and those around it; or over these alone, NaN for none; (V,) float64."""
    heights = mesh.vertices.astype(np.float64) @ np.array(up, np.float64)
    if own:
        around = [np.append(rows, v) for v, rows in enumerate(around)]
    return np.array([np.ptp(heights[rows]) if len(rows) else np.nan for rows in around])


def mean_edge_angles(mesh, normals):
    """Mean angle between the normal of a vertex and those of its neighbors; 0 without neighbors."""
    topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    a, b = normals.astype(np.float64)[topology.edges.astype(np.int64).T]
    angles = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ij,ij->i", a, b))
    ends = topology.edges.ravel()
    total = np.bincount(ends, np.repeat(angles, 2), topology.vertex_count)
    return total / np.maximum(np.bincount(ends, minlength=topology.vertex_count), 1)


def roughness(around, angles, own=True):
    """Mean of angles over those around each vertex; itself counts too, or not as released."""
    total = np.array([angles[others].sum() for others in around]) + own * angles
    return total / np.maximum([len(others) + own for others in around], 1)


def ridge(mesh, normals, around, alone=0.0):
    """Mean distance of the tips of normals; `alone` where none is around."""
    tips = mesh.vertices.astype(np.float64) + normals
    return np.array(
        [
            np.linalg.norm(tips[others] - tips[v], axis=1).mean() if len(others) else alone
            for v, others in enumerate(around)
        ]
    )
