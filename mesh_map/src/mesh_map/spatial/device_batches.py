"""Batches on an OpenCL device whatever their size, for whoever wants one of his own choice.

SpatialIndex takes its device only for batches that are worth it. Where there is no device, or it
fails, also in the middle of a batch, the native code answers: the same, to the last bit.
"""

from typing import Any, Optional

import numpy as np

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.query_arguments import checked_rays
from mesh_map.spatial.back_end import OPENCL
from mesh_map.spatial.hits import RayHits, SurfacePoints
from mesh_map.spatial.spatial_index import SpatialIndex


class RayCaster:
    """Rays against the mesh of an index, on an OpenCL device whatever their number."""

    def __init__(self, index: SpatialIndex, device: Optional[str] = None) -> None:
        """Args:
        index: of the mesh.
        device: as that of SpatialIndex; None for the device of the index.
        """
        self._index = index
        self._device = index.device_of(device)

    def cast_batch(
        self,
        *,
        origins: Any,
        directions: Any,
        max_distance: Any = np.inf,
        cull_back_faces: bool = False,
        mask: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: str = OPENCL,
    ) -> RayHits:
        """As SpatialIndex.cast_batch()."""
        rays = checked_rays(origins, directions, max_distance)
        return RayHits(
            *self._index.ray_answers(
                self._device, rays, not cull_back_faces, mask, False, cancel, back_end
            )
        )

    def any_hit_batch(
        self,
        *,
        origins: Any,
        directions: Any,
        max_distance: Any = np.inf,
        cull_back_faces: bool = False,
        mask: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: str = OPENCL,
    ) -> np.ndarray:
        """As SpatialIndex.any_hit_batch()."""
        rays = checked_rays(origins, directions, max_distance)
        (hits,) = self._index.ray_answers(
            self._device, rays, not cull_back_faces, mask, True, cancel, back_end
        )
        return hits.view(np.bool_)


class ClosestPointFinder:
    """Closest points on the mesh of an index, on an OpenCL device whatever their number.

    Where normals are limited, the native code answers.
    """

    def __init__(self, index: SpatialIndex, device: Optional[str] = None) -> None:
        """Args:
        index: of the mesh.
        device: as that of SpatialIndex; None for the device of the index.
        """
        self._index = index
        self._device = index.device_of(device)

    def closest_batch(
        self,
        *,
        points: Any,
        max_distance: float = np.inf,
        normals: Optional[Any] = None,
        max_angle: Optional[float] = None,
        mask: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: str = OPENCL,
    ) -> SurfacePoints:
        """As SpatialIndex.closest_batch()."""
        limit = (normals, max_angle)
        return self._index.closest_answers(
            self._device, points, max_distance, limit, mask, cancel, back_end
        )
