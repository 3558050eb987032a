"""Values for single vertices that have none, from those around them."""
import numpy as np


def mended_normals(
    normals: np.ndarray, bad: np.ndarray, vertices: np.ndarray, faces: np.ndarray
) -> np.ndarray:
    """Normals (V, 3) float32 in which the bad ones (V,) follow from the faces around their vertex.

    Faces count by their area, as in mesh_map. Zero where there is none with an area.
    """
    near = faces[bad[faces].any(axis=1)]
    a, b, c = np.moveaxis(vertices[near].astype(np.float64), 1, 0)
    sums = _sums(near, np.cross(b - a, c - a), len(normals))
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        unit = np.where(length > 0, sums / np.where(length > 0, length, 1), 0)
    return np.where(bad[:, None], unit, normals).astype(np.float32)


def mended_coordinates(uv: np.ndarray, bad: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Texture coordinates (V, 2) float32 in which each bad one (V,) is the mean of those that are
    in a face with it. Zero where there are none.
    """
    near = faces[bad[faces].any(axis=1)]
    good = ~bad[near]
    values = np.where(good[:, :, None], uv[near].astype(np.float64), 0).sum(axis=1)
    sums = _sums(near, values, len(uv))
    counts = _sums(near, good.sum(axis=1, keepdims=True).astype(np.float64), len(uv))
    mean = sums / np.maximum(counts, 1)
    return np.where(bad[:, None], mean, uv).astype(np.float32)


def _sums(faces, values, count):
    """(count, C): of values (F, C) over the faces (F, 3) at each vertex."""
    corners, repeated = faces.ravel(), np.repeat(values, 3, axis=0)
    columns = [np.bincount(corners, column, minlength=count) for column in repeated.T]
    return np.stack(columns, axis=1)
