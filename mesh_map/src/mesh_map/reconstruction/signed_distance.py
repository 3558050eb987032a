"""A truncated signed distance field of scans, and the surface where it is zero."""

import io
import json
import math
import zipfile
from typing import Any, Dict, NamedTuple, Optional

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_vertices

from mesh_map import _kernels
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import MeshMapError
from mesh_map.base.query_arguments import thread_count

DEFAULT_TRUNCATION = 2.0  # voxels
_MOST_BYTES = (1 << 63) - 1
_STATE = "mesh_map signed distance field 1"
_ARRAYS = (
    "keys",
    "distances",
    "weights",
    "observations",
    "colors",
    "intensities",
    "cell_keys",
    "cell_numbers",
)


class FieldMemoryError(MeshMapError):
    """A field would have needed more memory than it may; what it had before is still there."""


class IntegrationReport(NamedTuple):
    """What became of points: how many were used, and how many were left out for which reason."""

    used: int
    not_finite: int
    too_near: int
    too_far: int
    outside: int

    def __add__(self, other: Any) -> "IntegrationReport":
        return IntegrationReport(*(a + b for a, b in zip(self, other)))


class FieldSurface(NamedTuple):
    """A surface with what was averaged at its vertices.

    Attributes:
        vertices: (V, 3) float32 m in the map's frame.
        faces: (F, 3) uint32, counter-clockwise seen from where sensors were.
        normals: (V, 3) float32, the gradient of the field.
        colors: (V, 3) uint8, or None.
        intensities: (V,) float32, or None.
        observations: (V,) float32, rays that ended near the vertex.
    """

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    colors: Optional[np.ndarray]
    intensities: Optional[np.ndarray]
    observations: np.ndarray


class SignedDistanceField:
    """Distances to measured surfaces, in voxels around them.

    The result is the same with any number of threads; it depends on the order of the points. One
    thread at a time.

    Attributes:
        voxel_size, truncation: m.
    """

    def __init__(
        self,
        *,
        voxel_size: float,
        truncation: Optional[float] = None,
        min_range: float = 0.0,
        max_range: float = math.inf,
        carve: bool = False,
        colors: bool = False,
        intensities: bool = False,
        memory_limit: Optional[int] = None,
        threads: int = 0,
    ) -> None:
        """
        Args:
            voxel_size: m.
            truncation: m up to which distances are kept; None: 2 voxels. Things thinner than
                it, seen from both sides, grow together.
            min_range, max_range: m from the sensor; points nearer or farther are left out.
            carve: True to empty again what rays pass through before they end.
            colors, intensities: whether these are kept.
            memory_limit: bytes of the field; None: no limit.
            threads: 0 for all cores.

        Raises:
            ValueError: sizes that are none.
        """
        if not 0 < voxel_size < math.inf:
            raise ValueError(f"voxel_size is {voxel_size} m, but has to be above 0 and finite")
        self.voxel_size = float(voxel_size)
        self.truncation = DEFAULT_TRUNCATION * voxel_size if truncation is None else truncation
        if not voxel_size <= self.truncation < math.inf:
            raise ValueError(
                f"truncation is {truncation} m, but has to be at least the voxel size"
                f" ({voxel_size} m), and finite"
            )
        if not 0 <= min_range < max_range:
            raise ValueError(f"ranges from {min_range} to {max_range} m are not ascending")
        self._threads = thread_count(threads)
        self._limit = _MOST_BYTES if memory_limit is None else int(memory_limit)
        self._options: Dict[str, Any] = {
            "voxel_size": self.voxel_size,
            "truncation": float(self.truncation),
            "min_range": float(min_range),
            "max_range": float(max_range),
            "carve": bool(carve),
            "colors": bool(colors),
            "intensities": bool(intensities),
        }
        self._field = _kernels._SignedDistanceField(*self._options.values(), self._limit)

    @property
    def memory(self) -> int:
        """Bytes of the field, without the surface."""
        return self._field._memory

    @property
    def block_count(self) -> int:
        """Blocks of 8 x 8 x 8 voxels."""
        return self._field._blocks

    def integrate(
        self,
        points: Any,
        origins: Any,
        *,
        colors: Optional[np.ndarray] = None,
        intensities: Optional[np.ndarray] = None,
        cancel: Optional[CancelFlag] = None,
    ) -> IntegrationReport:
        """Adds measured points.

        Args:
            points: (N, 3) m in the map's frame; those that are not finite are left out.
            origins: (3,) m where the sensor was, or (N, 3) for each point.
            colors: (N, 3) uint8.
            intensities: (N,).
            cancel: ends it with Canceled; some of the points may then have been added.

        Raises:
            ValueError: another shape.
            FieldMemoryError: the limit would be exceeded; some of the points may have been added,
                all before are.
            Canceled: by `cancel`.
        """
        measured = as_vertices(points)
        starts = np.ascontiguousarray(np.reshape(np.float32(origins), (-1, 3)))
        shades = None if colors is None else np.ascontiguousarray(colors, np.uint8)
        strengths = None if intensities is None else np.ascontiguousarray(intensities, np.float32)
        arguments = measured, starts, shades, strengths, self._threads, kernel_flag(cancel)
        try:
            return IntegrationReport(*self._field._integrate(*arguments))
        except _kernels._FieldMemoryError as error:
            raise FieldMemoryError(
                f"the field needs {int(error.args[0]) / 1e6:.1f} MB, more than its limit of"
                f" {self._limit / 1e6:.1f} MB; take larger voxels, a smaller range, or more memory"
            ) from error

    def extract(
        self, *, least_weight: float = 0.05, cancel: Optional[CancelFlag] = None
    ) -> FieldSurface:
        """The surface of all points so far; only what has changed since the last time is made anew.

        Args:
            least_weight: what a voxel has to weigh to count; a ray from near, at right angles,
                weighs 1.
            cancel: ends it with Canceled; nothing has changed then.
        """
        vertices, faces, normals, colors, intensities, observations = self._field._extract(
            least_weight, self._threads, kernel_flag(cancel)
        )
        return FieldSurface(
            vertices,
            faces,
            normals,
            colors if self._options["colors"] else None,
            intensities if self._options["intensities"] else None,
            observations,
        )

    def to_bytes(self) -> bytes:
        """All of the field for from_bytes(): a NumPy archive (.npz)."""
        target = io.BytesIO()
        arrays = dict(zip(_ARRAYS, self._field._state()))
        head = json.dumps({"format": _STATE, "options": self._options})
        np.savez(target, head=np.array(head), **arrays)
        return target.getvalue()

    @classmethod
    def from_bytes(
        cls, data: bytes, *, memory_limit: Optional[int] = None, threads: int = 0
    ) -> "SignedDistanceField":
        """A field that was kept: it goes on as if it had not been interrupted.

        Args:
            data: of to_bytes().
            memory_limit, threads: as for the field.

        Raises:
            ValueError: data that is damaged, or something else.
        """
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as archive:
                head = json.loads(str(archive["head"]))
                arrays = [np.ascontiguousarray(archive[name]) for name in _ARRAYS]
            if head["format"] != _STATE:
                raise ValueError("its format is " + str(head["format"]))
            field = cls(**head["options"], memory_limit=memory_limit, threads=threads)
            field._field._restore(*arrays)
        except (ValueError, KeyError, TypeError, OSError, EOFError, zipfile.BadZipFile) as error:
            raise ValueError(f"this is no state of a signed distance field: {error}") from error
        return field
