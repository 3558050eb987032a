"""Poses of a robot set on the surface."""

import numpy as np

from mesh_map.geometry import MeshGeometry
from mesh_map.hits import NO_FACE, SurfacePoints

from mesh_navigation.up_normals import face_up_normals

_NO_DIRECTION = 1e-6


def standing_poses(
    geometry: MeshGeometry, orientations: np.ndarray, carried: SurfacePoints
) -> np.ndarray:
    """(N,4,4) matrices from the frame of a robot that stands there to that of the map.

    Its z axis is the normal of the surface, turned up; its x axis is that of the pose, along the
    surface. Of one that looks straight up or down, the y axis tells where it heads. So roll and
    pitch of poses make no difference. NaN off the map.

    Args:
        geometry: of the map.
        orientations: (N,4) quaternions x, y, z, w of any length but 0.
        carried: where it stands.
    """
    matrices = np.full((len(orientations), 4, 4), np.nan)
    found = carried.faces != NO_FACE
    up = face_up_normals(geometry, carried.faces[found].astype(np.int64))
    x_axes, y_axes = _axes(orientations[found])
    ahead, left = _along_surface(x_axes, up), _along_surface(y_axes, up)
    steep = np.linalg.norm(ahead, axis=1) < _NO_DIRECTION
    ahead[steep] = np.cross(left[steep], up[steep])
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    left = np.cross(up, ahead)
    matrices[found, :3] = np.stack([ahead, left, up, carried.positions[found]], axis=2)
    matrices[found, 3] = 0.0, 0.0, 0.0, 1.0
    return matrices


def _axes(orientations: np.ndarray) -> np.ndarray:
    """(2,N,3): the first two columns of the rotation matrices of quaternions."""
    x, y, z, w = (orientations / np.linalg.norm(orientations, axis=1, keepdims=True)).T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)], axis=1),
            np.stack([2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)], axis=1),
        ]
    )


def _along_surface(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """What of vectors (N,3) is at right angles to normals (N,3)."""
    return vectors - np.einsum("ni,ni->n", vectors, normals)[:, None] * normals
