"""The faces around vertices, for many vertices at once."""

from typing import Tuple

import numpy as np

from mesh_map.geometry.topology import Topology


def faces_around(topology: Topology, vertices: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """(M,) faces around the first vertex, then those around the second and so on.

    And (M,) int64 indices into ``vertices`` that say around which.
    """
    vertices = np.asarray(vertices, dtype=np.int64)
    starts = topology.vertex_face_offsets[vertices].astype(np.int64)
    counts = topology.vertex_face_offsets[vertices + 1] - starts
    owners = np.repeat(np.arange(len(vertices)), counts)
    places = np.arange(len(owners)) + np.repeat(starts - np.cumsum(counts) + counts, counts)
    return topology.vertex_faces[places], owners
