"""What a path over the surface costs, whatever a potential says of it."""

from typing import Optional

import numpy as np

from mesh_map.distance.surface_path import SurfacePath
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.surface import barycentric_coordinates


def travel_cost(
    geometry: MeshGeometry, path: SurfacePath, slowness: Optional[np.ndarray] = None
) -> float:
    """The integral of the slowness along a path: its length where that is 1.

    By the trapezoidal rule, which is exact where slowness is linear in a face (Pütz et al., eq.
    (4)). Corners that are closed do not count (a face with one is only entered at the ends of a
    path); where all are, a meter takes 1.

    Args:
        geometry: the mesh.
        path: with the faces of its pieces.
        slowness: (V,) float32, +inf where closed; None for 1.
    """
    lengths = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    if slowness is None or not len(lengths):
        return float(lengths.sum())
    corners = geometry.faces[path.faces]
    a, b, c = geometry.vertices[corners].astype(np.float64).transpose(1, 0, 2)
    of_corners = slowness[corners].astype(np.float64)
    is_open = np.isfinite(of_corners)
    of_corners[~is_open] = 0.0
    at_ends = []
    for points in (path.points[:-1], path.points[1:]):
        weights = np.clip(barycentric_coordinates(points, a, b, c), 0.0, 1.0)
        weights[np.isnan(weights)] = 1.0 / 3.0  # of a face without area
        weights *= is_open
        total = weights.sum(1)
        none = total <= 0.0
        found = (weights * of_corners).sum(1) / np.where(none, 1.0, total)
        at_ends.append(np.where(none, 1.0, found))
    return float((lengths * 0.5 * (at_ends[0] + at_ends[1])).sum())
