"""Rays against a mesh."""

import math
from typing import Any, Optional

import numpy as np

from mesh_map.back_end import AUTO
from mesh_map.cancel import CancelFlag
from mesh_map.hits import RayHit, RayHits
from mesh_map.query_arguments import mask_array, number
from mesh_map.raycast import RayCaster


class RayQueries:
    """The rays of mesh_map.spatial_index.SpatialIndex."""

    native: Any
    face_count: int
    _rays: RayCaster

    def cast(
        self,
        *,
        origin: Any,
        direction: Any,
        max_distance: float = math.inf,
        cull_back_faces: bool = False,
        mask: Optional[Any] = None,
    ) -> Optional[RayHit]:
        """Where a ray first meets the mesh, or None.

        Args:
            origin, direction: (3,); the direction has any length but 0.
            max_distance: meters.
            cull_back_faces: True to pass faces that are seen from behind (clockwise).
            mask: see SpatialIndex.
        Raises:
            ValueError: another shape.
        """
        if mask is not None:
            mask = mask_array(mask, self.face_count)
        limit = number(max_distance, "max_distance")
        found = self.native._cast(origin, direction, limit, not cull_back_faces, mask)
        return None if found is None else RayHit(*found)

    def cast_batch(
        self,
        *,
        origins: Any,
        directions: Any,
        max_distance: Any = math.inf,
        cull_back_faces: bool = False,
        mask: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: str = AUTO,
    ) -> RayHits:
        """Where each of N rays first meets the mesh.

        Args:
            origins: (N, 3), or (3,) for all.
            directions: (N, 3).
            max_distance: (N,) meters, or a number for all.
            cull_back_faces: as in cast().
            mask, cancel, back_end: see SpatialIndex.
        Raises:
            ValueError: another shape.
            Cancelled: by `cancel`.
        """
        return self._rays.cast_batch(
            origins=origins,
            directions=directions,
            max_distance=max_distance,
            cull_back_faces=cull_back_faces,
            mask=mask,
            cancel=cancel,
            back_end=back_end,
        )

    def any_hit(
        self,
        *,
        origin: Any,
        direction: Any,
        max_distance: float = math.inf,
        cull_back_faces: bool = False,
        mask: Optional[Any] = None,
    ) -> bool:
        """Whether a ray meets the mesh; quicker than cast(), of which it has the arguments."""
        if mask is not None:
            mask = mask_array(mask, self.face_count)
        limit = number(max_distance, "max_distance")
        return self.native._any_hit(origin, direction, limit, not cull_back_faces, mask)

    def any_hit_batch(
        self,
        *,
        origins: Any,
        directions: Any,
        max_distance: Any = math.inf,
        cull_back_faces: bool = False,
        mask: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: str = AUTO,
    ) -> np.ndarray:
        """Whether each of N rays meets the mesh, (N,) bool; as cast_batch()."""
        return self._rays.any_hit_batch(
            origins=origins,
            directions=directions,
            max_distance=max_distance,
            cull_back_faces=cull_back_faces,
            mask=mask,
            cancel=cancel,
            back_end=back_end,
        )
