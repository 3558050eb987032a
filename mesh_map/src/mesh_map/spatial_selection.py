"""Faces in a region: balls, frustums, boxes, and polygons on the screen."""

from typing import TYPE_CHECKING, Any, Optional, Sequence, Tuple

import numpy as np

from mesh_map import _kernels
from mesh_map.back_end import AUTO, Arrays, MeshDevice
from mesh_map.cancel import CancelFlag
from mesh_map.query_arguments import Rays, choice, float_array, mask_array, number, vector

if TYPE_CHECKING:
    from mesh_map.raycast import RayCaster

TOUCHING, INSIDE, VISIBLE = "touching", "inside", "visible"
_MOST_PIXELS = 1 << 28  # a ray of 24 bytes is cast through each
_NOWHERE = np.zeros(0, np.uint32)


class FaceSelections:
    """The selections of mesh_map.spatial_index.SpatialIndex.

    All return face indices, (N,) uint32, ascending. A face touches a region if any point of it is
    in it, borders included, whether or not a corner is. Modes:

    "touching": faces that touch the region;
    "inside": faces of which all is in the region;
    "visible": faces that touch it and can be seen from an eye. A face is seen if nothing is between
        the eye and one of four points spread over it, or a point of it in the region where none of
        these is (what is no farther from the point than neighboring float32 are does not count).
        With pixels or a viewport, it is seen if it shows in the middle of a pixel.
    """

    native: Any
    threads: int
    face_count: int
    _device: MeshDevice
    _rays: "RayCaster"

    def in_sphere(
        self,
        *,
        center: Any,
        radius: float,
        mode: str = TOUCHING,
        mask: Optional[Any] = None,
        eye: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
        back_end: str = AUTO,
    ) -> np.ndarray:
        """The faces in a ball.

        Args:
            center: (3,) meters.
            radius: meters; 0 for a point, below 0 for nothing.
            mode: see the class.
            mask, cancel, back_end: see SpatialIndex.
            eye: (3,) meters, for "visible".
        Raises:
            ValueError: another shape or mode, or an eye that is missing.
            Cancelled: by `cancel`.
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
        back_end: str = AUTO,
    ) -> np.ndarray:
        """The faces on the inner side of all planes.

        Args:
            planes: (P, 4), 1 to 16 rows a, b, c, d of any scale: a x + b y + c z + d >= 0 inside.
            mode: see the class.
            mask, cancel, back_end: see SpatialIndex.
            eye: (3,) meters, for "visible".
            pixels: columns and rows, for "visible": the first four planes are then the left, right,
                lower and upper sides of a picture, and meet in the eye.
        Raises:
            ValueError: another shape or mode, an eye that is missing or not that of the planes.
            Cancelled: by `cancel`.
        """
        region = _kernels._convex(float_array(planes, "planes", (None, 4)))
        if choice(mode, "mode", (TOUCHING, INSIDE, VISIBLE)) != VISIBLE or pixels is None:
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
        back_end: str = AUTO,
    ) -> np.ndarray:
        """The faces in a box of any orientation.

        Args:
            center: (3,) meters.
            axes: (3, 3), a unit vector in each row, at right angles (to 1e-6).
            half_size: (3,) meters from the center to the sides along the axes; below 0 for
                nothing.
            mode: see the class.
            mask, cancel, back_end: see SpatialIndex.
            eye: (3,) meters, for "visible".
        Raises:
            ValueError: another shape or mode, axes that are not orthonormal, or an eye that is
                missing.
            Cancelled: by `cancel`.
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
        back_end: str = AUTO,
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
            mask, cancel, back_end: see SpatialIndex.
            eye: (3,) meters, for "visible" without a viewport.
        Raises:
            ValueError: another shape or mode, an eye that is missing, or a matrix without inverse.
            Cancelled: by `cancel`.
        """
        corners = float_array(polygon, "polygon", (None, 2))
        matrix = float_array(view_projection, "view_projection", (4, 4))
        size = None if viewport is None else _picture_size(viewport, "viewport")
        if size is not None:
            corners = corners * [2.0 / size[0], -2.0 / size[1]] + [-1.0, 1.0]
        region = _kernels._lasso(corners, matrix)
        if choice(mode, "mode", (TOUCHING, INSIDE, VISIBLE)) != VISIBLE or size is None:
            return self._faces_in(region, "lasso", mode, mask, eye, cancel, back_end)
        if not (np.isfinite(corners).all() and np.isfinite(matrix).all() and len(corners) > 2):
            return _NOWHERE
        return self._in_picture(
            region, _kernels._lasso_pixels(region, *size), mask, cancel, back_end
        )

    def _faces_in(
        self,
        region: Any,
        query: str,
        mode: str,
        mask: Optional[Any],
        eye: Optional[Any],
        cancel: Optional[CancelFlag],
        back_end: str,
    ) -> np.ndarray:
        choice(mode, "mode", (TOUCHING, INSIDE, VISIBLE))
        start = _checked_eye(eye) if mode == VISIBLE else None
        bvh = self.native
        checked = mask_array(mask, self.face_count)
        faces = self._selected(bvh, region, query, mode == INSIDE, checked, back_end)
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
        back_end: str,
    ) -> np.ndarray:
        checked = mask_array(mask, self.face_count)
        return self.native._in_picture(region, *rays, checked, self._caster(cancel, back_end))

    def _caster(self, cancel: Optional[CancelFlag], back_end: str) -> Any:
        """What the kernels call for batches of rays."""

        def cast(
            origins: np.ndarray, directions: np.ndarray, limits: Optional[np.ndarray]
        ) -> Arrays:
            rays = Rays(origins, directions, np.array([np.inf]) if limits is None else limits)
            return self._rays.answers(rays, True, None, False, cancel, back_end)

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
