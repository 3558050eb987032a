"""Geometric questions about a mesh: rays, closest points, and the faces in a region."""

import math
from copy import copy
from types import SimpleNamespace
from typing import Any, Callable, Iterator, Optional, Sequence, Tuple, Union

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import Canceled, Cancelled  # noqa: F401
from mesh_map.base.query_arguments import (
    Rays,
    checked_rays,
    choice,
    float_array,
    mask_array,
    normal_limit,
    number,
    points_array,
    thread_count,
    vector,
)
from mesh_map.spatial.back_end import (  # noqa: F401
    AUTO,
    NATIVE,
    OPENCL,
    MeshDevice,
    query_counts,
)
from mesh_map.spatial.hits import (  # noqa: F401
    NO_FACE,
    RayHit,
    RayHits,
    SurfacePoint,
    SurfacePoints,
)
from mesh_map.spatial.opencl.device import device_wish
from mesh_map.spatial.opencl.device_queries import Arrays, DeviceQueries

Progress = Callable[[float], None]

TOUCHING, INSIDE, VISIBLE = "touching", "inside", "visible"
_MOST_PIXELS = 1 << 28  # a ray of 24 bytes is cast through each
_NOWHERE = np.zeros(0, np.uint32)


class SpatialIndex:
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
        cancel: CancelFlag that ends the batch with Canceled.
        back_end: "auto", "native", or "opencl" for a device whatever the size of the batch (and
            native code where there is none, or it fails: the same answers, to the last bit); None
            for "auto", or of an index by on_device() for "opencl".

    Selections are face indices, (N,) uint32, ascending. A face touches a region if any point of it
    is in it, borders included, whether or not a corner is. Modes:

    "touching": faces that touch the region;
    "inside": faces of which all is in the region;
    "visible": faces that touch it and can be seen from an eye. A face is seen if nothing is between
        the eye and one of four points spread over it, or a point of it in the region where none of
        these is (what is no farther from the point than neighboring float32 are does not count).
        With pixels or a viewport, it is seen if it shows in the middle of a pixel.
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
            Canceled: by `cancel`.
        """
        wish, threads = device_wish(device), thread_count(threads)
        corners, triangles = as_vertices(vertices), as_faces(faces)
        flag = kernel_flag(cancel)
        bvh = _kernels._Bvh._build(corners, triangles, threads, flag, progress)
        self._set_up(bvh, triangles, threads, wish)

    def _set_up(self, bvh: Any, faces: np.ndarray, threads: int, wish: str) -> None:
        self._shared = SimpleNamespace(bvh=bvh)  # with what on_device() makes; replaced as a whole
        self.threads = threads
        self.face_count = len(faces)
        self._faces = read_only(faces)
        self._device = MeshDevice(wish, threads)
        self._usual_back_end = AUTO

    def on_device(self, device: Optional[str] = None) -> "SpatialIndex":
        """The same index for batches on an OpenCL device whatever their size.

        Args:
            device: as for the index; None for the device that it has.
        """
        other = copy(self)
        other._usual_back_end = OPENCL
        if device is not None:
            other._device = MeshDevice(device_wish(device), self.threads)
        return other

    @property
    def native(self) -> Any:
        return self._shared.bvh

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
            ValueError, Canceled: as for the index; then nothing has changed.
        """
        flag = kernel_flag(cancel)
        corners = as_vertices(vertices)
        old = self.native
        self._shared.bvh = old._refitted(corners, self._faces, self.threads, flag, progress)

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
            mask: see the class.
        Raises:
            ValueError: another shape.
        """
        limits = self._limits(max_distance, cull_back_faces, mask)
        found = self.native._cast(origin, direction, *limits)
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
        back_end: Optional[str] = None,
    ) -> RayHits:
        """Where each of N rays first meets the mesh.

        Args:
            origins: (N, 3), or (3,) for all.
            directions: (N, 3).
            max_distance: (N,) meters, or a number for all.
            cull_back_faces: as in cast().
            mask, cancel, back_end: see the class.
        Raises:
            ValueError: another shape.
            Canceled: by `cancel`.
        """
        rays = checked_rays(origins, directions, max_distance)
        return RayHits(*self._cast(rays, not cull_back_faces, mask, False, cancel, back_end))

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
        limits = self._limits(max_distance, cull_back_faces, mask)
        return self.native._any_hit(origin, direction, *limits)

    def _limits(self, max_distance: Any, cull_back_faces: bool, mask: Optional[Any]) -> Any:
        limit = number(max_distance, "max_distance")
        return limit, not cull_back_faces, mask_array(mask, self.face_count)

    def any_hit_batch(
        self,
        *,
        origins: Any,
        directions: Any,
        max_distance: Any = math.inf,
        cull_back_faces: bool = False,
        mask: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: Optional[str] = None,
    ) -> np.ndarray:
        """Whether each of N rays meets the mesh, (N,) bool; as cast_batch()."""
        rays = checked_rays(origins, directions, max_distance)
        (hits,) = self._cast(rays, not cull_back_faces, mask, True, cancel, back_end)
        return hits.view(np.bool_)

    def _cast(
        self,
        rays: Rays,
        back_faces: bool,
        mask: Optional[Any],
        any_hit: bool,
        cancel: Optional[CancelFlag],
        back_end: Optional[str],
    ) -> Arrays:
        """(faces, distances, barycentric), or (hits,) as uint8."""
        checked, flag = mask_array(mask, self.face_count), kernel_flag(cancel)
        bvh = self.native

        def ask_native(begin: int) -> Arrays:
            asked = (*rays.part(begin), back_faces, checked, self.threads, flag)
            return (bvh._any_hit_batch(*asked),) if any_hit else bvh._cast_batch(*asked)

        def ask_device(device: DeviceQueries) -> Iterator[Arrays]:
            return device.cast(rays, back_faces, checked, any_hit, cancel)

        chosen = self._chosen(back_end)
        return self._device.batch("ray", rays.count, chosen, bvh, ask_device, ask_native)

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
        angle = normal_limit(normal, max_angle, 1, "normal").max_angle
        distance = number(max_distance, "max_distance")
        checked = mask_array(mask, self.face_count)
        found = self.native._closest(point, distance, normal, angle, checked)
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
        back_end: Optional[str] = None,
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
            Canceled: by `cancel`.
        """
        queries = points_array(points, "points")
        limit = normal_limit(normals, max_angle, len(queries), "normals")
        checked, flag = mask_array(mask, self.face_count), kernel_flag(cancel)
        distance = number(max_distance, "max_distance")
        bvh = self.native

        def ask_native(begin: int) -> Arrays:
            asked = (queries[begin:], distance, *limit, checked, self.threads, flag)
            return bvh._closest_batch(*asked)

        def ask_device(device: DeviceQueries) -> Iterator[Arrays]:
            return device.closest(queries, distance, checked, cancel)

        chosen = self._chosen(back_end)
        if limit.normals is not None:  # which no kernel of a device knows
            chosen = NATIVE
        count = len(queries)
        found = self._device.batch("closest_point", count, chosen, bvh, ask_device, ask_native)
        return SurfacePoints(*found)

    def in_sphere(
        self,
        *,
        center: Any,
        radius: float,
        mode: str = TOUCHING,
        mask: Optional[Any] = None,
        eye: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: Optional[str] = None,
    ) -> np.ndarray:
        """The faces in a ball.

        Args:
            center: (3,) meters.
            radius: meters; 0 for a point, below 0 for nothing.
            mode: see the class.
            mask, cancel, back_end: see the class.
            eye: (3,) meters, for "visible".
        Raises:
            ValueError: another shape or mode, or an eye that is missing.
            Canceled: by `cancel`.
        """
        region = _kernels._sphere(center, number(radius, "radius"))
        return self._faces_in(region, "sphere", mode, mask, eye, cancel, back_end)

    def in_frustum(
        self,
        *,
        planes: Any,
        mode: str = TOUCHING,
        mask: Optional[Any] = None,
        eye: Optional[Any] = None,
        pixels: Optional[Sequence[int]] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: Optional[str] = None,
    ) -> np.ndarray:
        """The faces on the inner side of all planes.

        Args:
            planes: (P, 4), 1 to 16 rows a, b, c, d of any scale: a x + b y + c z + d >= 0 inside.
            mode: see the class.
            mask, cancel, back_end: see the class.
            eye: (3,) meters, for "visible".
            pixels: columns and rows, for "visible": the first four planes are then the left, right,
                lower and upper sides of a picture, and meet in the eye.
        Raises:
            ValueError: another shape or mode, an eye that is missing or not that of the planes.
            Canceled: by `cancel`.
        """
        region = _kernels._convex(float_array(planes, "planes", (None, 4)))
        if mode != VISIBLE or pixels is None:
            return self._faces_in(region, "frustum", mode, mask, eye, cancel, back_end)
        size = _picture_size(pixels, "pixels")
        start = _checked_eye(eye)
        if not (np.isfinite(start).all() and np.isfinite(planes).all()):
            return _NOWHERE
        rays = _kernels._frustum_pixels(region, start, *size)
        return self._in_picture(region, rays, mask, cancel, back_end)

    def in_box(
        self,
        *,
        center: Any,
        axes: Any,
        half_size: Any,
        mode: str = TOUCHING,
        mask: Optional[Any] = None,
        eye: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: Optional[str] = None,
    ) -> np.ndarray:
        """The faces in a box of any orientation.

        Args:
            center: (3,) meters.
            axes: (3, 3), a unit vector in each row, at right angles (to 1e-6).
            half_size: (3,) meters from the center to the sides along the axes; below 0 for
                nothing.
            mode: see the class.
            mask, cancel, back_end: see the class.
            eye: (3,) meters, for "visible".
        Raises:
            ValueError: another shape or mode, axes that are not orthonormal, or an eye that is
                missing.
            Canceled: by `cancel`.
        """
        rows = float_array(axes, "axes", (3, 3))
        off = np.abs(rows @ rows.T - np.eye(3)).max() if np.isfinite(rows).all() else 0.0
        if off > 1e-6:
            raise ValueError(
                "axes have to be unit vectors at right angles, one in each row; they are off by %g"
                ": numpy.linalg.qr makes such ones, half_size takes the lengths" % off
            )
        region = _kernels._box(center, rows, half_size)
        return self._faces_in(region, "frustum", mode, mask, eye, cancel, back_end)

    def in_polygon(
        self,
        *,
        polygon: Any,
        view_projection: Any,
        viewport: Optional[Sequence[int]] = None,
        mode: str = TOUCHING,
        mask: Optional[Any] = None,
        eye: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: Optional[str] = None,
    ) -> np.ndarray:
        """The faces that a camera has within a polygon (lasso) on its screen.

        They lie between its near and far plane. Where the polygon crosses itself, the even-odd rule
        tells what is inside; its edges are.

        Args:
            polygon: (N, 2) corners in normalized device coordinates: -1 to 1 on the screen, x to
                the right, y up; what lies beyond the screen counts as well. Less than 3 enclose
                nothing.
            view_projection: (4, 4), projection times view as OpenGL and OGRE have it: it takes
                columns (x, y, z, 1) in the frame of the mesh to clip space, -w <= z <= w.
            viewport: width and height in pixels: the polygon is then in pixels, x to the right, y
                down, as Qt tells them.
            mode: see the class; "visible" needs a viewport or an eye.
            mask, cancel, back_end: see the class.
            eye: (3,) meters, for "visible" without a viewport.
        Raises:
            ValueError: another shape or mode, an eye that is missing, or a matrix without inverse.
            Canceled: by `cancel`.
        """
        corners = float_array(polygon, "polygon", (None, 2))
        matrix = float_array(view_projection, "view_projection", (4, 4))
        size = None if viewport is None else _picture_size(viewport, "viewport")
        if size is not None:
            corners = corners * [2.0 / size[0], -2.0 / size[1]] + [-1.0, 1.0]
        region = _kernels._lasso(corners, matrix)
        if mode != VISIBLE or size is None:
            return self._faces_in(region, "lasso", mode, mask, eye, cancel, back_end)
        if not (np.isfinite(corners).all() and np.isfinite(matrix).all() and len(corners) > 2):
            return _NOWHERE
        return self._in_picture(
            region, _kernels._lasso_pixels(region, *size), mask, cancel, back_end
        )

    def _chosen(self, back_end: Optional[str]) -> str:
        wanted = self._usual_back_end if back_end is None else back_end
        return choice(wanted, "back_end", (AUTO, NATIVE, OPENCL))

    def _faces_in(
        self,
        region: Any,
        query: str,
        mode: str,
        mask: Optional[Any],
        eye: Optional[Any],
        cancel: Optional[CancelFlag],
        back_end: Optional[str],
    ) -> np.ndarray:
        choice(mode, "mode", (TOUCHING, INSIDE, VISIBLE))
        start = _checked_eye(eye) if mode == VISIBLE else None
        bvh = self.native
        checked = mask_array(mask, self.face_count)
        faces = self._selected(bvh, region, query, mode == INSIDE, checked, self._chosen(back_end))
        if start is None:
            return faces
        if not np.isfinite(start).all():
            return _NOWHERE
        return bvh._seen(region, faces, start, self._caster(cancel, back_end))

    def _selected(
        self,
        bvh: Any,
        region: Any,
        query: str,
        inside: bool,
        mask: Optional[np.ndarray],
        back_end: str,
    ) -> np.ndarray:
        # Of a mesh that is too small as a whole, nothing needs to be looked at.
        device = self._device.for_batch(query, self.face_count, back_end, bvh)
        if device is not None and query != "lasso":  # which no kernel knows
            roots, below = bvh._selection_roots(region)
            if len(roots) and self._device.for_batch(query, below, back_end, bvh) is not None:
                try:
                    faces = device.select(region, roots, inside, mask)
                except Exception as error:  # drivers fail in any way
                    self._device.give_up(error)
                else:
                    _kernels._count_opencl(query, 1)
                    return faces
        return bvh._select(region, inside, mask)

    def _in_picture(
        self,
        region: Any,
        rays: Tuple[np.ndarray, np.ndarray],
        mask: Optional[Any],
        cancel: Optional[CancelFlag],
        back_end: Optional[str],
    ) -> np.ndarray:
        checked = mask_array(mask, self.face_count)
        return self.native._in_picture(region, *rays, checked, self._caster(cancel, back_end))

    def _caster(self, cancel: Optional[CancelFlag], back_end: Optional[str]) -> Any:
        """What the kernels call for batches of rays."""

        def cast(
            origins: np.ndarray, directions: np.ndarray, limits: Optional[np.ndarray]
        ) -> Arrays:
            rays = Rays(origins, directions, np.array([np.inf]) if limits is None else limits)
            return self._cast(rays, True, None, False, cancel, back_end)

        return cast


def _checked_eye(eye: Optional[Any]) -> np.ndarray:
    if eye is None:
        raise ValueError(
            "the mode visible needs an eye: 3 numbers, the point that the faces are seen from"
        )
    return vector(eye, "eye")


def _picture_size(size: Any, name: str) -> Tuple[int, int]:
    numbers = np.asarray(size)
    if numbers.shape != (2,) or numbers.dtype.kind not in "iu" or not (numbers > 0).all():
        raise ValueError("%s has to be two whole numbers above 0, not %r" % (name, size))
    columns, rows = (int(number) for number in numbers)
    if columns * rows > _MOST_PIXELS:
        raise ValueError(
            "%s has %d x %d pixels, more than %d; ask for a part of the picture, or for fewer"
            % (name, columns, rows, _MOST_PIXELS)
        )
    return columns, rows
