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


def surface_heights(mesh, around, radius, sides=40):
    """Samples of the heights that the surface of large faces has around each vertex.

    Of the faces with a side longer than the radius at the vertex and at those around it: points of
    a grid within the radius, and where the ways to those outside of it leave it.

    Returns:
        lowest, highest: (V,) float64; of a vertex without such faces inf, -inf.
        slack: (V,) the largest distance of points beside each other.
    """
    points = mesh.vertices.astype(np.float64)
    faces = mesh.faces.astype(np.int64)
    corners = points[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    topology = Topology(faces=mesh.faces, vertex_count=len(points))
    u, v = (grid.ravel() / sides for grid in np.mgrid[: sides + 1, : sides + 1])
    weights = np.stack([1 - u - v, u, v], 1)[u + v <= 1 + 1e-9]
    lowest, highest, slack = np.full(len(points), np.inf), np.full(len(points), -np.inf), []
    for center, others in enumerate(around):
        near = [topology.faces_of(w) for w in (center, *others)]
        near = np.unique(np.concatenate(near)).astype(np.int64)
        near = near[longest[near] > radius]
        slack.append(longest[near].max(initial=0.0) / sides)
        for face in near:
            ways = weights @ corners[face] - points[center]
            far = np.linalg.norm(ways, axis=1)
            inner = ways[far.argmin()]  # a corner at least is within the radius
            a, b = np.einsum("ij,ij->i", ways - inner, ways - inner), (ways - inner) @ inner
            c = inner @ inner - radius * radius
            with np.errstate(divide="ignore", invalid="ignore"):
                part = (np.sqrt(b * b - a * c) - b) / a
            part = np.where(far > radius, part, 1.0)
            z = points[center, 2] + inner[2] + part * (ways - inner)[:, 2]
            lowest[center] = min(lowest[center], z.min())
            highest[center] = max(highest[center], z.max())
    return lowest, highest, np.array(slack)


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
