"""Normals of faces and vertices."""

from typing import Any, Optional, Tuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

from mesh_map import _kernels
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.topology import Topology

UP = (0.0, 0.0, 1.0)


def face_normals(vertices: Any, faces: Any, up: Any = UP) -> Tuple[np.ndarray, np.ndarray]:
    """Unit normals of faces, to the side from which their corners run counter-clockwise.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        up: (3,) of length 1, for faces without area, as in the released mesh_map.
    Returns:
        normals: (F, 3) float32.
        without_area: (F,) bool.
    Raises:
        ValueError: wrong shapes, or a face that refers to no vertex.
    """
    normals, without_area = _kernels._face_normals(as_vertices(vertices), as_faces(faces), up)
    return normals, without_area.view(np.bool_)


def corner_angles(vertices: Any, faces: Any) -> np.ndarray:
    """(F, 3) float32, the interior angles of faces in radians; 0 where they cannot be told.

    Raises:
        ValueError: wrong shapes, or a face that refers to no vertex.
    """
    return _kernels._corner_angles(as_vertices(vertices), as_faces(faces))


def vertex_normals(
    topology: Topology,
    normals_of_faces: np.ndarray,
    without_area: np.ndarray,
    faces: Optional[np.ndarray] = None,
    weights: Optional[np.ndarray] = None,
    up: Any = UP,
) -> np.ndarray:
    """Unit normals of vertices: the mean of the unit normals of the faces around.

    Without weights, each face counts the same, whatever its size or angle (Gouraud, Continuous
    shading of curved surfaces, 1971), as in the released mesh_map: thresholds in the field were
    chosen for that. Faces without area do not count. With the angles as weights: Thürmer and
    Wüthrich, Computing vertex normals from polygonal facets, 1998.

    Args:
        topology: of the mesh.
        normals_of_faces, without_area: from face_normals().
        faces, weights: both (F, 3) or none: the corners, and how much each counts at its vertex,
            such as corner_angles().
        up: (3,) of length 1: the normal where there is no face, or the normals around cancel out.
    Returns:
        (V, 3) float32.
    Raises:
        ValueError: arrays of another mesh.
    """
    return _kernels._vertex_normals(
        np.ascontiguousarray(normals_of_faces, np.float32),
        topology.vertex_face_offsets,
        topology.vertex_faces,
        np.ascontiguousarray(without_area, np.bool_).view(np.uint8),
        None if weights is None else as_faces(faces),
        None if weights is None else as_vertices(weights),
        up,
    )


def unit_normals(normals: Any, up: Any = UP) -> np.ndarray:
    """(V, 3) float32 of length 1; rows that have this length, up to 0.1 %, stay as they are.

    Args:
        normals: (V, 3) finite numbers.
        up: (3,) of length 1, for rows of zeros.
    """
    given = as_vertices(normals)
    squared = np.einsum("ij,ij->i", given, given)
    off = np.flatnonzero(~(np.abs(squared - 1.0) < 0.002))
    if not len(off):
        return given
    rows = given[off].astype(np.float64)
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    result = given.copy()
    result[off] = np.where(lengths > 0.0, rows / np.where(lengths > 0.0, lengths, 1.0), up)
    return result


def checked_up(direction: Any) -> np.ndarray:
    """(3,) float64 of length 1.

    Raises:
        MeshMapError: not three finite numbers, or all zero.
    """
    try:
        checked = np.array(direction, np.float64)
    except (TypeError, ValueError):
        checked = np.zeros(0)
    largest = np.abs(checked).max() if checked.shape == (3,) else 0.0
    if not 0.0 < largest < np.inf:
        raise MeshMapError(
            "up_direction is %r, but it has to be three finite numbers, not all 0" % (direction,)
        )
    checked /= largest  # no square is 0 or too large then
    return checked / np.linalg.norm(checked)
