"""Normals of faces and vertices."""

from typing import Any, Tuple

import numpy as np

from mesh_map import _kernels
from mesh_map.array_checks import as_faces, as_vertices
from mesh_map.topology import Topology


def face_normals(vertices: Any, faces: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Unit normals of faces, to the side from which their corners run counter-clockwise.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
    Returns:
        normals: (F, 3) float32; (0, 0, 1) for a face without area, as in the released mesh_map.
        without_area: (F,) bool.
    Raises:
        ValueError: wrong shapes, or a face that refers to no vertex.
    """
    normals, without_area = _kernels._face_normals(as_vertices(vertices), as_faces(faces))
    return normals, without_area.view(np.bool_)


def vertex_normals(
    topology: Topology, normals_of_faces: np.ndarray, without_area: np.ndarray
) -> np.ndarray:
    """Unit normals of vertices: the mean of the unit normals of the faces around.

    Each face counts the same, whatever its size or angle, as in the released mesh_map: thresholds
    in the field were chosen for that. Faces without area do not count.

    Args:
        topology: of the mesh.
        normals_of_faces, without_area: from face_normals().
    Returns:
        (V, 3) float32; (0, 0, 1) where there is no face, or the normals around cancel out.
    Raises:
        ValueError: arrays of another mesh.
    """
    return _kernels._vertex_normals(
        np.ascontiguousarray(normals_of_faces, np.float32),
        topology.vertex_face_offsets,
        topology.vertex_faces,
        np.ascontiguousarray(without_area, np.bool_).view(np.uint8),
    )
