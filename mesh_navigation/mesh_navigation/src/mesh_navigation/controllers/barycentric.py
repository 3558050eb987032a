"""Barycentric coordinates."""

import numpy as np

from mesh_map.surface import barycentric_coordinates


def inside(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(3,) weights of the corners (3,3) of a face at a point (3,) of it.

    Where rounding has put the point beside the face, those of a point in it.
    """
    weights = barycentric_coordinates(point, *corners).clip(0.0, 1.0)
    return weights / weights.sum()
