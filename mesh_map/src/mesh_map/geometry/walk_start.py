"""In which face a walk begins where several meet."""

import math
from typing import Any, List, Optional

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry

_HERE = 1e-9  # weight of a corner: less is none
_STEEP = 0.5  # cosine of the slope from where on nobody stands on a face beside a gentler one


def walk_start(
    geometry: MeshGeometry,
    point: Any,
    direction: Any,
    up: Any,
    mask: Optional[np.ndarray] = None,
) -> Any:
    """The same point in the face around it that carries who looks in a direction.

    Where faces meet, which of them is nearest is chance; one that is upright there has no heading
    for most directions. It is the face that contains the direction as seen along `up`; of several,
    or if none does, or all that do are steeper than 60 degrees, the one that faces up most; then
    that of lowest index.

    Args:
        geometry: the mesh.
        point: with a face and barycentric coordinates, such as a SurfacePoint.
        direction, up: (3,) of any length.
        mask: (F,) bool, the faces that may be chosen; the given one stays where there is no other.
    Returns:
        The point, with another face and other barycentric coordinates where it lies on an edge or a
        corner and another face carries it.
    """
    weights = point.barycentric.tolist()
    if min(weights) > _HERE:
        return point
    corners = [int(vertex) for vertex in geometry.faces[point.face]]
    here = [vertex for vertex, weight in zip(corners, weights) if weight > _HERE]
    faces = _faces_with(geometry, here)
    faces = faces[~geometry.faces_without_area[faces]]
    if mask is not None:
        faces = faces[mask[faces]]
    if not len(faces):
        return point
    axis = np.asarray(up, np.float64)
    axis = axis / np.linalg.norm(axis)
    best = max(faces.tolist(), key=lambda face: _rank(geometry, face, here, direction, axis))
    if best == point.face:
        return point
    of_corner = dict(zip(corners, weights))
    kept = np.array([of_corner[v] if v in here else 0.0 for v in geometry.faces[best].tolist()])
    return point._replace(face=best, barycentric=kept / kept.sum())


def _faces_with(geometry: MeshGeometry, vertices: List[int]) -> np.ndarray:
    """Faces that have all of these vertices, ascending."""
    found = geometry.topology.faces_of(vertices[0])
    for vertex in vertices[1:]:
        found = np.intersect1d(found, geometry.topology.faces_of(vertex))
    return found.astype(np.int64)


def _rank(
    geometry: MeshGeometry, face: int, here: List[int], direction: Any, up: np.ndarray
) -> Any:
    """What makes a face the better one, the more important first; equal for equal faces."""
    flatness = abs(float(geometry.face_normals[face] @ up))
    contains = flatness >= _STEEP and _contains(geometry, face, here, direction, up)
    return contains, round(flatness, 6)


def _contains(
    geometry: MeshGeometry, face: int, here: List[int], direction: Any, up: np.ndarray
) -> bool:
    """Whether a direction leads from a corner, or from a side, into a face as seen along `up`."""
    corners = [int(vertex) for vertex in geometry.faces[face]]
    a, b, c = geometry.vertices[corners].astype(np.float64)
    turn = math.copysign(1.0, float(up @ np.cross(b - a, c - a)))
    for k in range(3):
        start, end = corners[k], corners[(k + 1) % 3]
        # of the sides on which the point lies, it is on the inner side
        if all(vertex in (start, end) for vertex in here):
            side = geometry.vertices[end].astype(np.float64) - geometry.vertices[start]
            if turn * float(up @ np.cross(side, direction)) < 0.0:
                return False
    return True
