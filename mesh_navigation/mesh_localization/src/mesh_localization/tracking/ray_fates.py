"""What became of the rays of a scan: which the map explains, and which not."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.spatial.hits import NO_FACE

_BESIDE = 5.0  # times the tolerance, that a ray may end before or behind a slanted surface


class RayFate(IntEnum):
    """Of one ray."""

    EXPLAINED = 0
    """It ends on the map's surface."""
    BEFORE = 1
    """It ends before the surface: something is there that is not on the map."""
    THROUGH = 2
    """It goes through the surface: something of the map is not there."""
    OFF_MAP = 3
    """It meets no surface at all: the map says nothing there."""


class RayFates(NamedTuple):
    """
    Attributes:
        fates: (N,) uint8, a RayFate for each ray.
        distances: (N,) m of the points from the planes that their rays meet; NaN where they meet
            none.
        residual: m, root mean square of the distances of the rays that are explained; NaN without.
    """

    fates: np.ndarray
    distances: np.ndarray
    residual: float

    def count(self, fate: RayFate) -> int:
        """How many rays."""
        return int(np.count_nonzero(self.fates == fate))

    @property
    def share(self) -> float:
        """Of the rays that meet the map or go through it, those that it explains, 0 to 1; 0 where
        there are none. Obstacles before it do not count: they say nothing of what is behind."""
        explained, through = self.count(RayFate.EXPLAINED), self.count(RayFate.THROUGH)
        return explained / max(1, explained + through)


def ray_fates(
    target: PlaneTarget,
    points: np.ndarray,
    origins: np.ndarray,
    pose: np.ndarray,
    tolerance: float,
) -> RayFates:
    """The fate of each ray.

    Args:
        target: the map.
        points: (N, 3) m in the robot's frame.
        origins: (N, 3) or (3,) there, where the sensor was.
        pose: (4, 4) of the robot in the map.
        tolerance: m from a plane, up to which a point lies on it.
    """
    rays = target.cast(points, origins, pose)
    nothing = rays.hits.faces == NO_FACE
    beyond = rays.ranges - np.where(nothing, 0.0, rays.hits.distances)
    slant = np.einsum("ij,ij->i", rays.normals, rays.directions)
    distances = np.where(nothing, np.nan, beyond * slant)
    fates = np.where(beyond < 0, RayFate.BEFORE, RayFate.THROUGH).astype(np.uint8)
    with np.errstate(invalid="ignore"):
        near = (np.abs(distances) <= tolerance) & (np.abs(beyond) <= _BESIDE * tolerance)
    fates[near] = RayFate.EXPLAINED
    fates[nothing] = RayFate.OFF_MAP
    residual = float(np.sqrt(np.mean(distances[near] ** 2))) if near.any() else np.nan
    return RayFates(fates, distances, residual)
