"""What queries about a mesh find."""

from typing import Any, NamedTuple

import numpy as np

from mesh_map import _kernels

NO_FACE = int(_kernels._NO_INDEX)


class SurfacePoint(NamedTuple):
    """A point of a mesh.

    face: index.
    position: (3,) float64, meters.
    barycentric: (3,) float64, weights of the corners of the face, which sum up to 1.
    distance: meters from the point that was asked for, on either side of the surface; of a RayHit
        from the origin of the ray.
    """

    face: int
    position: np.ndarray
    barycentric: np.ndarray
    distance: float


class SurfacePoints(NamedTuple):
    """N points of a mesh as arrays.

    faces: (N,) uint32, NO_FACE where there is none.
    positions, barycentric: (N, 3) float64; zeros where there is none.
    distances: (N,) float64; +inf where there is none.
    """

    faces: np.ndarray
    positions: np.ndarray
    barycentric: np.ndarray
    distances: np.ndarray


class RayHit(SurfacePoint):
    """Where a ray meets a mesh: origin + distance * unit direction, at a distance >= 0."""

    __slots__ = ()


class RayHits(NamedTuple):
    """Where N rays meet a mesh, as arrays.

    faces: (N,) uint32, NO_FACE where a ray meets nothing.
    distances: (N,) float64, meters from the origins; +inf where a ray meets nothing.
    barycentric: (N, 3) float64, weights of the corners; zeros where a ray meets nothing.
    """

    faces: np.ndarray
    distances: np.ndarray
    barycentric: np.ndarray

    def positions(self, *, origins: Any, directions: Any) -> np.ndarray:
        """(N, 3) float64, meters; NaN where a ray meets nothing.

        Args:
            origins, directions: those of the rays.
        """
        origins = np.asarray(origins, np.float64).reshape(-1, 3)
        directions = np.asarray(directions, np.float64).reshape(-1, 3)
        result = np.full((len(self.faces), 3), np.nan)
        hit = self.faces != NO_FACE
        if len(origins) == len(hit):
            origins = origins[hit]
        directions = directions[hit]
        largest = np.abs(directions).max(axis=1, keepdims=True, initial=0.0)
        units = directions / largest  # of which no square is 0 or too large
        units /= np.linalg.norm(units, axis=1, keepdims=True)
        result[hit] = origins + self.distances[hit, None] * units
        return result
