"""The generated outdoor world with exactly as many triangles as asked for."""

from typing import Tuple

import numpy as np
from mesh_msgs.outdoor_world import outdoor_world


def exact_world(faces: int, seed: int = 0) -> Tuple[np.ndarray, np.ndarray]:
    """Vertices float32 (V, 3) in meters and faces uint32 (F, 3) with F == `faces`.

    It is `outdoor_world` of about that size; what is too much is cut off at the border of the
    world, and what lacks is made by splitting triangles at their centroids.

    :raises ValueError: if `faces` is not within 1,000 .. 10,000,000.
    """
    world = outdoor_world(faces=faces, seed=seed)
    vertices, triangles = world.vertices, np.ascontiguousarray(world.faces, np.uint32)
    surplus = len(triangles) - faces
    if surplus < 0:
        # a split makes three of one; where an odd number lacks, one triangle more is cut off first
        vertices, triangles = _cut(vertices, triangles, -surplus % 2)
        vertices, triangles = _split(vertices, triangles, (1 - surplus) // 2)
    else:
        vertices, triangles = _cut(vertices, triangles, surplus)
    return vertices, triangles


def _cut(vertices: np.ndarray, faces: np.ndarray, count: int) -> Tuple[np.ndarray, np.ndarray]:
    """Without the `count` faces nearest to the border, and without vertices that no face has."""
    if not count:
        return vertices, faces
    corners = np.abs(vertices[:, :2]).max(axis=1)[faces]
    kept = np.sort(np.argsort(corners.max(axis=1), kind="stable")[: len(faces) - count])
    used = np.zeros(len(vertices), bool)
    used[faces[kept]] = True
    number = np.cumsum(used, dtype=np.int64) - 1
    return vertices[used], number[faces[kept]].astype(np.uint32)


def _split(vertices: np.ndarray, faces: np.ndarray, count: int) -> Tuple[np.ndarray, np.ndarray]:
    """The first `count` faces cut into three each: two faces more for each of them."""
    cut = faces[:count]
    centers = vertices[cut].mean(axis=1, dtype=np.float64).astype(np.float32)
    center = np.arange(len(vertices), len(vertices) + count, dtype=np.uint32)
    parts = [np.stack([cut[:, k], cut[:, (k + 1) % 3], center], axis=1) for k in range(3)]
    faces = np.concatenate(parts + [faces[count:]])
    return np.concatenate([vertices, centers]), np.ascontiguousarray(faces, np.uint32)
