"""Points on and near the surface of a mesh."""

from typing import Any, NamedTuple

import numpy as np

from mesh_map import _kernels
from mesh_map.array_checks import as_faces, as_vertices

NO_FACE = int(_kernels._NO_INDEX)


class SurfacePoint(NamedTuple):
    """A point of a mesh.

    face: index.
    position: (3,) float64, meters.
    barycentric: (3,) float64, weights of the corners of the face, which sum up to 1.
    distance: meters from the point that was asked for, on either side of the surface.
    """

    face: int
    position: np.ndarray
    barycentric: np.ndarray
    distance: float


class SurfacePoints(NamedTuple):
    """N points of a mesh as arrays.

    faces: (N,) uint32, NO_FACE where there is none.
    positions, barycentric: (N, 3) float64.
    distances: (N,) float64.
    """

    faces: np.ndarray
    positions: np.ndarray
    barycentric: np.ndarray
    distances: np.ndarray


def barycentric_coordinates(points: Any, a: Any, b: Any, c: Any) -> np.ndarray:
    """Coordinates (alpha, beta, gamma) of the projections of points on the planes of triangles abc.

    Equation 1 of the paper (Heidrich's method): the projection is alpha a + beta b + gamma c.

    Args:
        points, a, b, c: (..., 3), broadcast against each other.
    Returns:
        (..., 3) float64; NaN for a triangle without area.
    """
    points, a, b, c = (np.asarray(array, np.float64) for array in (points, a, b, c))
    u, v, w = b - a, c - a, points - a
    n = np.cross(u, v)
    with np.errstate(invalid="ignore", divide="ignore"):
        squared = np.sum(n * n, axis=-1)
        gamma = np.sum(np.cross(u, w) * n, axis=-1) / squared
        beta = np.sum(np.cross(w, v) * n, axis=-1) / squared
        return np.stack([1.0 - gamma - beta, beta, gamma], axis=-1)


def is_inside(barycentric: Any, tolerance: float = 0.0) -> np.ndarray:
    """Whether projections lie inside their triangles.

    Equation 2 of the paper, widened by the tolerance.

    Args:
        barycentric: (..., 3), from barycentric_coordinates(). NaN is outside.
    Returns:
        (...) bool.
    """
    barycentric = np.asarray(barycentric)
    inside = (barycentric >= -tolerance) & (barycentric <= 1.0 + tolerance)
    return np.all(inside, axis=-1)


def closest_points(
    *, vertices: Any, faces: Any, points: Any, max_distance: float = float("inf")
) -> SurfacePoints:
    """The nearest point of a mesh for each of N points.

    Exact: every face is looked at, in double precision. Of several faces as near, the one of
    lowest index is named. A point that is not finite finds nothing.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        points: (N, 3) meters.
        max_distance: meters, >= 0; counts on both sides of the surface.
    Raises:
        ValueError: wrong shapes, a face that refers to no vertex, or a distance that is negative or
            NaN.
    """
    queries = np.ascontiguousarray(points, np.float64)
    found, barycentric, positions, distances = _kernels._closest_points(
        as_vertices(vertices), as_faces(faces), queries, float(max_distance)
    )
    return SurfacePoints(found, positions, barycentric, distances)
