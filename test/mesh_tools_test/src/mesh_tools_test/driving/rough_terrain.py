"""Rough ground, as of a scanned field that was ploughed: short edges, each corner off its place."""

from typing import Tuple

import numpy as np
from mesh_msgs import zoo

EDGE, NOISE = 0.1, 0.05  # m
_WAVES = ((7.0, 0.35), (3.1, 0.12))  # m: lengths and amplitudes of what lies below


def rough_terrain(size: float = 30.0, seed: int = 0) -> Tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) float32 m and faces (F, 3) uint32: a square of irregular triangles.

    Each vertex is up to 5 cm above or below rolling ground, so that neighbors differ by up to as
    much as they are apart, and slopes are patchy with places too steep, or with steps too high. (Of
    normal noise with a deviation of 5 cm the shipped layers leave little: within 0.3 m, half of the
    ground differs by more than the robot climbs.)
    """
    random = np.random.default_rng(seed)
    mesh = zoo.jittered_plane(int(round(size / EDGE)), size, seed)
    vertices = mesh.vertices.astype(np.float64)
    height = random.uniform(-NOISE, NOISE, len(vertices))
    for wave, amplitude in _WAVES:
        for _ in range(3):
            angle, phase = random.uniform(0.0, 2.0 * np.pi, 2)
            along = vertices[:, :2] @ [np.cos(angle), np.sin(angle)]
            height += amplitude / 2 * np.sin(2.0 * np.pi * along / wave + phase)
    vertices[:, 2] = height
    return vertices.astype(np.float32), mesh.faces.astype(np.uint32)
