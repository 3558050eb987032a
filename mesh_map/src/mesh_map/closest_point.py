"""Batches of closest points, on an OpenCL device where there is one."""

from typing import TYPE_CHECKING, Any, Iterator, Optional

import numpy as np

from mesh_map.back_end import AUTO, NATIVE, OPENCL, Arrays
from mesh_map.cancel import CancelFlag, kernel_flag
from mesh_map.hits import SurfacePoints
from mesh_map.query_arguments import choice, mask_array, normal_limit, number, points_array

if TYPE_CHECKING:
    from mesh_map.opencl.device_queries import DeviceQueries
    from mesh_map.spatial_index import SpatialIndex


class ClosestPointFinder:
    """Closest points on the mesh of an index, on an OpenCL device whatever their number.

    Where there is no device, or it fails, also in the middle of a batch, the native code answers:
    the same, to the last bit. So it does where normals are limited. SpatialIndex.closest_batch()
    takes the device only for batches that are worth it.
    """

    def __init__(self, index: "SpatialIndex", device: Optional[str] = None) -> None:
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
        index = self._index
        bvh, threads = index.native, index.threads
        queries = points_array(points, "points")
        limit = normal_limit(normals, max_angle, len(queries), "normals")
        checked, flag = mask_array(mask, index.face_count), kernel_flag(cancel)
        distance = number(max_distance, "max_distance")

        def natively(begin: int) -> Arrays:
            rest = queries[begin:]
            return bvh._closest_batch(rest, distance, *limit, checked, threads, flag)

        def on_device(device: "DeviceQueries") -> Iterator[Arrays]:
            return device.closest(queries, distance, checked, cancel)

        count = len(queries)
        if limit.normals is not None:  # which no kernel knows
            choice(back_end, "back_end", (AUTO, NATIVE, OPENCL))
            return SurfacePoints(*natively(0))
        return SurfacePoints(
            *self._device.batch("closest_point", count, back_end, bvh, on_device, natively)
        )
