"""The vertices that say what the ground is like: of each point of the surface, its nearest corner.

So start and goal of plans are judged, see `mesh_navigation.surface.face_points`.
"""

from typing import NamedTuple, Tuple

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.walk import WalkPath


def _squared_distances(geometry: MeshGeometry, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(N,3) m^2, of points (N,3) from the corners of faces (N,)."""
    corners = geometry.vertices[geometry.faces[faces]].astype(np.float64)
    offsets = corners - points[:, None]
    return np.einsum("nij,nij->ni", offsets, offsets)


def nearest_corners(geometry: MeshGeometry, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(N,) int64: of faces (N,), the corner nearest to a point of each (N,3); of equals the first.

    Args:
        geometry: of the map.
        faces: indices.
        points: m, each in its face.
    """
    faces = np.asarray(faces).astype(np.int64)
    nearest = np.argmin(_squared_distances(geometry, faces, points), axis=1)
    return geometry.faces[faces, nearest].astype(np.int64)


class CornersAlong(NamedTuple):
    """What lies along a way over the surface, in its order."""

    vertices: np.ndarray
    """(K,) int64: nearest corners; none follows itself."""
    entered: np.ndarray
    """(K,) m along the way, from where on each is the nearest."""


def corners_along(geometry: MeshGeometry, path: WalkPath) -> CornersAlong:
    """The nearest corners of all points of a way.

    Args:
        geometry: of the map.
        path: a way over the surface, see `mesh_map.geometry.walk`.
    """
    begins, ends = path.points[:-1], path.points[1:]
    corners, shares = corners_of_pieces(geometry, path.faces, begins, ends)
    lengths = np.linalg.norm(ends - begins, axis=1)
    before = np.concatenate([[0.0], np.cumsum(lengths)])[:-1]
    vertices = corners.ravel()
    entered = (before[:, None] + shares * lengths[:, None]).ravel()
    changes = np.diff(vertices, prepend=-1) != 0
    return CornersAlong(vertices[changes], entered[changes])


def corners_of_pieces(
    geometry: MeshGeometry, faces: np.ndarray, begins: np.ndarray, ends: np.ndarray
) -> Tuple[np.ndarray, np.ndarray]:
    """The nearest corners of all points of straight pieces, each within a face.

    Between the two ends of a piece, squared distances from the corners differ by linear functions.
    So the third corner is the nearest somewhere only if it is where the two that are nearest at the
    ends are equally near.

    Args:
        geometry: of the map.
        faces: (N,) indices.
        begins, ends: (N,3) m.

    Returns:
        (N,3) int64: the nearest corners from begin to end, the first one twice if there is no third
        between; and (N,3): the shares of the pieces from where on they are.
    """
    faces = np.asarray(faces).astype(np.int64)
    begin = _squared_distances(geometry, faces, begins)
    end = _squared_distances(geometry, faces, ends)
    rows = np.arange(len(faces))

    def equally_near(near: np.ndarray, then: np.ndarray) -> np.ndarray:
        ahead = begin[rows, then] - begin[rows, near]
        behind = end[rows, near] - end[rows, then]
        total = ahead + behind
        return np.where(total > 0.0, ahead / np.where(total > 0.0, total, 1.0), 0.0)

    first, last = np.argmin(begin, axis=1), np.argmin(end, axis=1)
    third = np.clip(3 - first - last, 0, 2)
    share = equally_near(first, last)
    between = begin + share[:, None] * (end - begin)
    three = (first != last) & (between[rows, third] < between[rows, first])
    middle = np.where(three, third, first)
    shares = np.stack(
        [np.zeros(len(faces)), equally_near(first, middle), equally_near(middle, last)], axis=1
    )
    order = np.stack([first, middle, last], axis=1)
    return geometry.faces[faces[:, None], order].astype(np.int64), shares
