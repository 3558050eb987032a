"""Geometric questions about a mesh: rays, closest points, and the faces in a region."""

import math
from typing import Any, Callable, Optional, Union

import numpy as np

from mesh_map import _kernels
from mesh_map.array_checks import as_faces, as_vertices, read_only
from mesh_map.back_end import AUTO, MeshDevice, query_counts
from mesh_map.cancel import CancelFlag, kernel_flag
from mesh_map.closest_point import ClosestPointFinder
from mesh_map.errors import Cancelled
from mesh_map.hits import NO_FACE, RayHit, RayHits, SurfacePoint, SurfacePoints
from mesh_map.opencl.device import device_wish
from mesh_map.query_arguments import mask_array, normal_limit, number, thread_count
from mesh_map.ray_queries import RayQueries
from mesh_map.raycast import RayCaster
from mesh_map.spatial_selection import FaceSelections

__all__ = [
    "Cancelled",
    "NO_FACE",
    "RayHit",
    "RayHits",
    "SpatialIndex",
    "SurfacePoint",
    "SurfacePoints",
    "query_counts",
]

Progress = Callable[[float], None]


class SpatialIndex(RayQueries, FaceSelections):
    """A bounding volume hierarchy over the faces of a mesh.

    Every query answers as if it had looked at every face in double precision, whichever back end
    answers: native code, or for batches that are worth it an OpenCL device, where there is one.
    Lengths are in meters, in the frame of the mesh. Any thread may ask at any time; the GIL is
    released meanwhile. Ctrl+C ends a batch within milliseconds.

    Ties: of faces as near (equal in double precision), the one of lowest index is named. A ray hits
    the edges and corners of a face, too, but no face without area, nor one whose plane contains the
    ray (unless rounding gives it an area). A closest point may be on a face without area, unless
    normals are limited.

    Numbers that are not finite, a direction or normal of length 0 and negative distances are no
    mistake: such a query finds nothing.

    Attributes:
        face_count: F.
        threads: for batches; 0 for all cores.
        native: the kernel of the hierarchy, for the modules of this package.

    Arguments of all batches and selections:
        mask: (F,) bool, True for each face that counts; None for all. Faces that do not count are
            passed by rays as if they were not there, except in the mode "visible", where they hide
            what is behind them.
        cancel: CancelFlag that ends the batch with Cancelled.
        back_end: "auto", "native", or "opencl" for a device whatever the size of the batch (and
            native code where there is none).
    """

    def __init__(
        self,
        vertices: Any,
        faces: Any,
        threads: int = 0,
        device: str = AUTO,
        progress: Optional[Progress] = None,
        cancel: Optional[CancelFlag] = None,
    ) -> None:
        """Builds the index.

        Args:
            vertices: (V, 3); copied.
            faces: (F, 3) vertex indices, at least one face; kept for refit(), so not to be changed.
            threads: to build with and for batches; 0 for all cores.
            device: OpenCL device for batches. "auto": what the environment variable
                MESH_TOOLS_OPENCL says, else a GPU before a CPU; "off", "gpu", "cpu", or part of the
                name of a device or platform.
            progress: called with the share that is done, 0 to 1, never falling, by any thread, one
                call at a time. What it raises ends the build.
            cancel: ends the build when it is set.
        Raises:
            ValueError: wrong shapes, no faces, a face that refers to no vertex, or has one that is
                not finite (the first is named).
            Cancelled: by `cancel`.
        """
        wish, threads = device_wish(device), thread_count(threads)
        corners, triangles = as_vertices(vertices), as_faces(faces)
        flag = kernel_flag(cancel)
        bvh = _kernels._Bvh._build(corners, triangles, threads, flag, progress)
        self._set_up(bvh, triangles, threads, wish)

    def _set_up(self, bvh: Any, faces: np.ndarray, threads: int, wish: str) -> None:
        self.native = bvh
        self.threads = threads
        self.face_count = len(faces)
        self._faces = read_only(faces)
        self._device = MeshDevice(wish, threads)
        self._rays = RayCaster(self)
        self._points = ClosestPointFinder(self)

    @property
    def memory(self) -> int:
        """Bytes of the index, without what a device holds."""
        return self.native._memory

    @property
    def device(self) -> str:
        """One line: the OpenCL device for batches, or why there is none."""
        return self._device.text()

    def wait_for_device(self) -> bool:
        """Starts the OpenCL device, waits for that, and tells whether batches go there.

        Otherwise the first batch that is worth a device starts it in the background, and native
        code answers until it is ready.
        """
        return self._device.wait()

    def device_of(self, wish: Optional[str]) -> MeshDevice:
        """A device for this mesh; None for that of the index."""
        return self._device if wish is None else MeshDevice(device_wish(wish), self.threads)

    def refit(
        self,
        vertices: Any,
        progress: Optional[Progress] = None,
        cancel: Optional[CancelFlag] = None,
    ) -> None:
        """Takes moved vertices of the same faces: quicker than a new index, but queries get slower
        the more they have moved. Queries that run meanwhile are answered for the old ones.

        Args:
            vertices: (V, 3).
            progress, cancel: as for the index.
        Raises:
            ValueError, Cancelled: as for the index; then nothing has changed.
        """
        flag = kernel_flag(cancel)
        corners = as_vertices(vertices)
        self.native = self.native._refitted(corners, self._faces, self.threads, flag, progress)

    def to_bytes(self) -> bytes:
        """The index for from_bytes(), on machines of any byte order."""
        return self.native._serialize()

    @classmethod
    def from_bytes(
        cls,
        data: Union[bytes, bytearray, memoryview],
        vertices: Any,
        faces: Any,
        threads: int = 0,
        device: str = AUTO,
    ) -> "SpatialIndex":
        """An index that was kept, without building it.

        Args:
            data: of to_bytes(); may come from anywhere: all of it is checked.
            vertices, faces: the mesh that it was built for.
            threads, device: as for the index.
        Raises:
            ValueError: data that is damaged, of another version, or of another mesh.
        """
        wish, threads = device_wish(device), thread_count(threads)
        triangles = as_faces(faces)
        index = cls.__new__(cls)
        bvh = _kernels._Bvh._deserialize(bytes(data), as_vertices(vertices), triangles)
        index._set_up(bvh, triangles, threads, wish)
        return index

    def closest(
        self,
        *,
        point: Any,
        max_distance: float = math.inf,
        normal: Optional[Any] = None,
        max_angle: Optional[float] = None,
        mask: Optional[Any] = None,
    ) -> Optional[SurfacePoint]:
        """The point of the mesh that is nearest to a point, or None.

        Args:
            point: (3,).
            max_distance: meters, on either side of the surface.
            normal, max_angle: both or none: only faces count whose normal is within this angle
                (radians, 0 to pi) of this direction (3,), such as the upper of two storeys.
            mask: see the class.
        Raises:
            ValueError: another shape, or an angle out of its range.
        """
        if normal is None and max_angle is None:
            angle = math.pi
        else:
            angle = normal_limit(normal, max_angle, 1, "normal").max_angle
        if mask is not None:
            mask = mask_array(mask, self.face_count)
        distance = number(max_distance, "max_distance")
        found = self.native._closest(point, distance, normal, angle, mask)
        return None if found is None else SurfacePoint(*found)

    def closest_batch(
        self,
        *,
        points: Any,
        max_distance: float = math.inf,
        normals: Optional[Any] = None,
        max_angle: Optional[float] = None,
        mask: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: str = AUTO,
    ) -> SurfacePoints:
        """closest() for each of N points.

        Args:
            points: (N, 3).
            max_distance: meters.
            normals: (N, 3), or (3,) for all; with max_angle as in closest(). Native code answers
                then in any case.
            mask, cancel, back_end: see the class.
        Raises:
            ValueError: another shape, or an angle out of its range.
            Cancelled: by `cancel`.
        """
        return self._points.closest_batch(
            points=points,
            max_distance=max_distance,
            normals=normals,
            max_angle=max_angle,
            mask=mask,
            cancel=cancel,
            back_end=back_end,
        )
