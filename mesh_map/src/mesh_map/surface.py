"""Points on and near the surface of a mesh."""

from typing import Any

import numpy as np

from mesh_map.array_checks import as_faces, as_vertices
from mesh_map.hits import NO_FACE, SurfacePoint, SurfacePoints
from mesh_map.query_arguments import checked_distance, points_array
from mesh_map.spatial_index import SpatialIndex

__all__ = [
    "NO_FACE",
    "SurfacePoint",
    "SurfacePoints",
    "barycentric_coordinates",
    "closest_points",
    "is_inside",
]


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

    As SpatialIndex.closest_batch(), which is for more than one call about the same mesh: here the
    index is built anew each time. A mesh without faces has no nearest points.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        points: (N, 3) meters; one that is not finite finds nothing.
        max_distance: meters, >= 0; counts on both sides of the surface.
    Raises:
        ValueError: wrong shapes, a face that refers to no vertex, a vertex of a face that is not
            finite, or a distance that is negative or NaN.
    """
    corners, triangles = as_vertices(vertices), as_faces(faces)
    queries = points_array(points, "points")
    distance = checked_distance(max_distance)
    if not len(triangles):
        count = len(queries)
        return SurfacePoints(
            np.full(count, NO_FACE, np.uint32),
            np.zeros((count, 3)),
            np.zeros((count, 3)),
            np.full(count, np.inf),
        )
    index = SpatialIndex(corners, triangles)
    return index.closest_batch(points=queries, max_distance=distance)
