"""How near a track came to ground that must not be driven on."""

from typing import Any

import numpy as np

from mesh_map.mesh_map import MeshMap
from mesh_map.spatial_index import SpatialIndex


def clearances(mesh_map: MeshMap, positions: np.ndarray) -> np.ndarray:
    """(N,) m from each of (N,3) positions to the nearest lethal or unknown vertex; inf if none."""
    blocked = np.flatnonzero(~np.isfinite(mesh_map.planning_costs().costs))
    if not len(blocked):
        return np.full(len(positions), np.inf)
    # Faces that are points: the index finds the nearest without looking at all of them.
    points = np.repeat(np.arange(len(blocked))[:, None], 3, axis=1)
    index = SpatialIndex(mesh_map.vertices[blocked], points, device="off")
    return index.closest_batch(points=positions).distances


def on_blocked(mesh_map: MeshMap, place: Any) -> bool:
    """Whether a place of the surface is blocked: the nearest corner of its face, that of the
    largest weight, is lethal or unknown.

    Args:
        mesh_map: the map.
        place: what has a face and barycentric coordinates.
    """
    vertex = mesh_map.faces[place.face][np.argmax(place.barycentric)]
    return not np.isfinite(mesh_map.planning_costs().costs[vertex])
