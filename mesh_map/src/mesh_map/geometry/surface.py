"""Points on and near the surface of a mesh, and what is between its vertices there.

Pütz et al., here and elsewhere: The Mesh Tools package, introducing annotated 3D triangle maps in
ROS.
"""

from typing import Any, Tuple

import numpy as np

from mesh_map.spatial.hits import NO_FACE, SurfacePoint, SurfacePoints  # noqa: F401

# A corner of smaller weight does not count: what is said of an edge or vertex does not depend on
# the face that is looked at, also where points were rounded to 32-bit floats.
NO_WEIGHT = 1e-6


def barycentric_coordinates(points: Any, a: Any, b: Any, c: Any) -> np.ndarray:
    """Coordinates (alpha, beta, gamma) of the projections of points on the planes of triangles abc.

    Pütz et al., eq. (1), which is Heidrich's method (Computing the barycentric coordinates of a
    projected point, 2005): the projection is alpha a + beta b + gamma c.

    Args:
        points, a, b, c: (..., 3), broadcast against each other.
    Returns:
        (..., 3) float64; NaN for a triangle without area.
    """
    points, a, b, c = (np.asarray(array, np.float64) for array in (points, a, b, c))
    u, v, w = b - a, c - a, points - a
    n = _cross(u, v)
    with np.errstate(invalid="ignore", divide="ignore"):
        squared = np.sum(n * n, axis=-1)
        gamma = np.sum(_cross(u, w) * n, axis=-1) / squared
        beta = np.sum(_cross(w, v) * n, axis=-1) / squared
        return np.stack([1.0 - gamma - beta, beta, gamma], axis=-1)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of (..., 3); to the bit as np.cross(), which takes twice as long for a few of them."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def is_inside(barycentric: Any, tolerance: float = 0.0) -> np.ndarray:
    """Whether projections lie inside their triangles.

    Pütz et al., eq. (2), widened by the tolerance.

    Args:
        barycentric: (..., 3), from barycentric_coordinates(). NaN is outside.
    Returns:
        (...) bool.
    """
    barycentric = np.asarray(barycentric)
    inside = (barycentric >= -tolerance) & (barycentric <= 1.0 + tolerance)
    return np.all(inside, axis=-1)


def _at_corners(
    values: Any, faces: np.ndarray, points: Any
) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(N,) bool, which points have a face; of the M that do the weights of its corners, and the
    values there, (M, 3) and (M, 3) or (M, 3, K) float64.

    Weights are 0 for corners that do not count, of the sum 1, and NaN for what are no weights.
    """
    of_points = np.asarray(points.faces)
    found = of_points != NO_FACE
    barycentric = np.asarray(points.barycentric, np.float64)[found]
    weights = np.where(barycentric <= NO_WEIGHT, 0.0, barycentric)
    total = weights.sum(1, keepdims=True)
    corners = np.asarray(values)[faces[of_points[found]]].astype(np.float64)
    return found, weights / np.where(total > 0.0, total, np.nan), corners


def interpolate(values: Any, faces: np.ndarray, points: Any) -> np.ndarray:
    """A field of vertices at points of the surface (Pütz et al., eq. (4)).

    Of the corners of the face that have a weight (above 1e-6): +inf if one has +inf (lethal,
    unreached), else NaN if one is unknown, else linear.

    Args:
        values: (V,) or (V, K).
        faces: (F, 3) vertex indices.
        points: SurfacePoints or SurfaceWalks: faces (N,) and barycentric (N, 3).
    Returns:
        (N,) or (N, K) float64; NaN where there is no face.
    """
    found, weights, corners = _at_corners(values, faces, points)
    if corners.ndim == 3:
        weights = weights[:, :, None]
    counts = np.broadcast_to(weights != 0.0, corners.shape)
    infinite = (np.isposinf(corners) & counts).any(1)
    parts = np.multiply(
        corners, weights, out=np.zeros(corners.shape), where=counts & ~np.isposinf(corners)
    )
    result = np.full((len(found), *corners.shape[2:]), np.nan)
    result[found] = np.where(infinite, np.inf, parts.sum(1))
    return result


def interpolate_directions(vectors: Any, faces: np.ndarray, points: Any) -> np.ndarray:
    """A field of directions at points of the surface (Pütz et al., eq. (3)).

    Corners without a direction (0, or not finite) are left out, as in the released mesh_map.

    Args:
        vectors: (V, 3).
        faces: (F, 3) vertex indices.
        points: SurfacePoints or SurfaceWalks: faces (N,) and barycentric (N, 3).
    Returns:
        (N, 3) float64 of length 1; zeros where there is no face, no corner has a direction, or they
        cancel out.
    """
    found, weights, corners = _at_corners(vectors, faces, points)
    usable = np.isfinite(corners).all(2, keepdims=True)
    corners = np.where(usable, corners, 0.0)
    sums = np.einsum("nk,nkd->nd", weights, corners)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    largest = np.linalg.norm(corners, axis=2).max(1, initial=0.0)[:, None]
    exists = lengths > 1e-12 * largest
    result = np.zeros((len(found), 3))
    result[found] = np.where(exists, sums / np.where(exists, lengths, 1.0), 0.0)
    return result
