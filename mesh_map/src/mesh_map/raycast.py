"""Batches of rays, on an OpenCL device where there is one."""

from typing import TYPE_CHECKING, Any, Iterator, Optional

import numpy as np

from mesh_map.back_end import OPENCL, Arrays
from mesh_map.cancel import CancelFlag, kernel_flag
from mesh_map.hits import RayHits
from mesh_map.query_arguments import Rays, checked_rays, mask_array

if TYPE_CHECKING:
    from mesh_map.opencl.device_queries import DeviceQueries
    from mesh_map.spatial_index import SpatialIndex


class RayCaster:
    """Rays against the mesh of an index, on an OpenCL device whatever their number.

    Where there is no device, or it fails, also in the middle of a batch, the native code answers:
    the same, to the last bit. SpatialIndex.cast_batch() takes the device only for batches that are
    worth it.
    """

    def __init__(self, index: "SpatialIndex", device: Optional[str] = None) -> None:
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
        found = self.answers(rays, not cull_back_faces, mask, False, cancel, back_end)
        return RayHits(*found)

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
        (hits,) = self.answers(rays, not cull_back_faces, mask, True, cancel, back_end)
        return hits.view(np.bool_)

    def answers(
        self,
        rays: Rays,
        back_faces: bool,
        mask: Optional[Any],
        any_hit: bool,
        cancel: Optional[CancelFlag],
        back_end: str,
    ) -> Arrays:
        """(faces, distances, barycentric), or (hits,) as uint8."""
        index = self._index
        bvh, threads = index.native, index.threads
        checked, flag = mask_array(mask, index.face_count), kernel_flag(cancel)

        def natively(begin: int) -> Arrays:
            asked = (*rays.part(begin), back_faces, checked, threads, flag)
            return (bvh._any_hit_batch(*asked),) if any_hit else bvh._cast_batch(*asked)

        def on_device(device: "DeviceQueries") -> Iterator[Arrays]:
            return device.cast(rays, back_faces, checked, any_hit, cancel)

        return self._device.batch("ray", rays.count, back_end, bvh, on_device, natively)
