"""Where rays go through the map: what is not there any more."""

from typing import Dict, Tuple

import numpy as np
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.registration.rigid import moved
from mesh_map.spatial.hits import NO_FACE

from mesh_localization.tracking.localizer import BaseScan
from mesh_localization.tracking.ray_fates import RayFate, RayFates

CELL = 0.5  # m
_MOST_CELLS = 100_000


class ThroughCounts:
    """How many rays went through the map, by cells of 0.5 m.

    Attributes:
        changes: how often any were added.
    """

    def __init__(self) -> None:
        self.changes = 0
        self._counts: Dict[Tuple[int, int, int], int] = {}

    def add(self, target: PlaneTarget, scan: BaseScan, fates: RayFates, pose: np.ndarray) -> None:
        """Count the rays of a scan where they meet the surface that they go through.

        Args:
            target: the map.
            scan, fates: and what became of its rays.
            pose: (4, 4) of the base in the map.
        """
        through = fates.fates == RayFate.THROUGH
        if not through.any():
            return
        origins = np.broadcast_to(scan.origins, scan.points.shape)[through]
        rays = target.cast(scan.points[through], origins, pose)
        met = rays.hits.faces != NO_FACE
        starts = moved(pose, origins)
        places = starts + np.where(met, rays.hits.distances, 0.0)[:, None] * rays.directions
        cells, counts = np.unique(
            np.floor(places[met] / CELL).astype(np.int64), axis=0, return_counts=True
        )
        for cell, count in zip(map(tuple, cells.tolist()), counts.tolist()):
            if cell in self._counts or len(self._counts) < _MOST_CELLS:
                self._counts[cell] = self._counts.get(cell, 0) + count
        self.changes += 1

    def cells(self) -> Tuple[np.ndarray, np.ndarray]:
        """(C, 3) float64 m, the middle of each cell, and (C,) int64 rays that went through it."""
        places = np.array(list(self._counts), np.float64).reshape(-1, 3)
        return (places + 0.5) * CELL, np.array(list(self._counts.values()), np.int64)

    def clear(self) -> None:
        """Forget them, such as on another map."""
        self._counts.clear()
        self.changes += 1
