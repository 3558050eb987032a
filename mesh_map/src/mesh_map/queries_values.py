"""Values and directions between vertices: equations 3 and 4 of the paper."""

from typing import Any

import numpy as np

from mesh_map.hits import NO_FACE

# A corner of smaller weight does not count: what is said of an edge or vertex does not depend on
# the face that is looked at, also where points were rounded to 32-bit floats.
NO_WEIGHT = 1e-6


def _weights(barycentric: np.ndarray) -> np.ndarray:
    """(N, 3): 0 for corners that do not count, sum 1; NaN for what are no weights."""
    weights = np.where(barycentric <= NO_WEIGHT, 0.0, barycentric)
    total = weights.sum(1, keepdims=True)
    return weights / np.where(total > 0.0, total, np.nan)


def interpolate(values: Any, faces: np.ndarray, points: Any) -> np.ndarray:
    """A field of vertices at points of the surface (equation 4 of the paper).

    Of the corners of the face that have a weight (above 1e-6): +inf if one has +inf (lethal,
    unreached), else NaN if one is unknown, else linear.

    Args:
        values: (V,) or (V, K).
        faces: (F, 3) vertex indices.
        points: SurfacePoints or SurfaceWalks: faces (N,) and barycentric (N, 3).
    Returns:
        (N,) or (N, K) float64; NaN where there is no face.
    """
    field = np.asarray(values)
    found = np.asarray(points.faces) != NO_FACE
    weights = _weights(np.asarray(points.barycentric, np.float64)[found])
    corners = field[faces[np.asarray(points.faces)[found]]].astype(np.float64)
    if corners.ndim == 3:
        weights = weights[:, :, None]
    counts = np.broadcast_to(weights != 0.0, corners.shape)
    infinite = (np.isposinf(corners) & counts).any(1)
    parts = np.multiply(
        corners, weights, out=np.zeros(corners.shape), where=counts & ~np.isposinf(corners)
    )
    result = np.full((len(found), *field.shape[1:]), np.nan)
    result[found] = np.where(infinite, np.inf, parts.sum(1))
    return result


def interpolate_directions(vectors: Any, faces: np.ndarray, points: Any) -> np.ndarray:
    """A field of directions at points of the surface (equation 3 of the paper).

    Corners without a direction (0, or not finite) are left out, as in the released mesh_map.

    Args:
        vectors: (V, 3).
        faces: (F, 3) vertex indices.
        points: SurfacePoints or SurfaceWalks: faces (N,) and barycentric (N, 3).
    Returns:
        (N, 3) float64 of length 1; zeros where there is no face, no corner has a direction, or they
        cancel out.
    """
    field = np.asarray(vectors)
    found = np.asarray(points.faces) != NO_FACE
    weights = _weights(np.asarray(points.barycentric, np.float64)[found])
    corners = field[faces[np.asarray(points.faces)[found]]].astype(np.float64)
    usable = np.isfinite(corners).all(2, keepdims=True)
    corners = np.where(usable, corners, 0.0)
    sums = np.einsum("nk,nkd->nd", weights, corners)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    largest = np.linalg.norm(corners, axis=2).max(1, initial=0.0)[:, None]
    exists = lengths > 1e-12 * largest
    result = np.zeros((len(found), 3))
    result[found] = np.where(exists, sums / np.where(exists, lengths, 1.0), 0.0)
    return result
