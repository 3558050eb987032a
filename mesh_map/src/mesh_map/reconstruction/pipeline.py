"""From scans to a surface that one can drive on; nothing of ROS."""

import math
from dataclasses import replace
from typing import Any, Dict, Mapping, NamedTuple, Optional, Tuple

import numpy as np
from mesh_msgs_hdf5.model.mesh import Mesh

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import MeshMapError
from mesh_map.reconstruction.drivable_surface import SurfaceChanges, drivable
from mesh_map.reconstruction.options import FieldOptions, SurfaceOptions
from mesh_map.reconstruction.pose_jumps import PoseJumps
from mesh_map.reconstruction.signed_distance import IntegrationReport, SignedDistanceField
from mesh_map.reconstruction.surface_closing import OBSERVATIONS
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.scan import Scan

INTENSITY = "intensity"  # attribute of vertices
_ROUNDED = 2.0**-24  # of a coordinate, by float32
_FINE, _COARSE = 0.01, 0.1  # of a voxel, that rounding may be without an origin, and at all
BATCH_POINTS = 1 << 16  # of which a field takes all distances or, without memory for them, none
_NOTHING = IntegrationReport(0, 0, 0, 0, 0)


class _Begun(NamedTuple):
    """How many points of a scan of so many are in the field, and what became of them."""

    name: str
    count: int
    done: int
    report: IntegrationReport


class Reconstruction:
    """A surface that grows by scans.

    Args:
        options: of the field.
        memory_limit: bytes for the field, or None.
        left_out: takes what is left out.
        threads: 0 for all cores; the result is the same.
    Attributes:
        options, left_out: as given.
        scans, points: how many are in the field.
        origin: (3,) float64 m: what is added to its coordinates for those of the poses. Unless the
            options name it, it is the place of the first scan in whole meters where float32 would
            round coordinates there by more than a hundredth of a voxel, else 0.
    """

    def __init__(
        self,
        options: FieldOptions = FieldOptions(),
        memory_limit: Optional[int] = None,
        left_out: Optional[LeftOutCounts] = None,
        threads: int = 0,
    ) -> None:
        self.options, self._memory_limit, self._threads = options, memory_limit, threads
        self.left_out = LeftOutCounts() if left_out is None else left_out
        self.scans = self.points = 0
        self.origin = np.zeros(3)
        self._field: Optional[SignedDistanceField] = None
        self._colors = self._intensities = False
        self._jumps = PoseJumps(self.left_out)
        self._begun = _Begun("", 0, 0, _NOTHING)

    @property
    def memory(self) -> int:
        """Bytes of the field."""
        return 0 if self._field is None else int(self._field.memory)

    def add(self, scan: Scan) -> Optional[Scan]:
        """Put a scan into the field; the first one says whether there are colors and intensities.

        Returns:
            what of it was used, with its pose relative to the origin; None for nothing.
        Raises:
            FieldMemoryError: the memory limit is reached. Where a part of the scan is in the field
                already, it is not used again when the same scan comes next.
        """
        if self._field is None:
            self._begin(scan)
        assert self._field is not None
        placed = self._placed(self._decimated(scan))
        if placed is None:
            return None
        colors = self._channel(placed, "colors", self._colors)
        intensities = self._channel(placed, "intensities", self._intensities)
        report = self._integrated(placed, colors, intensities)
        self._jumps.add(placed)
        left = self.left_out
        left.add("decimated", scan.name, len(scan.points) - len(placed.points))
        left.add("too_near", scan.name, report.too_near)
        left.add("too_far", scan.name, report.too_far)
        left.add("outside", scan.name, report.outside)
        self.scans += 1
        self.points += report.used
        return placed

    def surface(
        self, options: SurfaceOptions = SurfaceOptions(), cancel: Optional[CancelFlag] = None
    ) -> Tuple[Mesh, SurfaceChanges]:
        """The surface of all scans so far, as a mesh that one can drive on, and what was done to
        it. Its vertices are relative to `origin`.

        Raises:
            MeshMapError: there is no surface.
            Canceled: by `cancel`; nothing has changed.
        """
        if self._field is None:
            raise MeshMapError("there is no scan, so there is no surface")
        found = self._field.extract(cancel=cancel)
        if not len(found.faces):
            text = "%d points of %d scans make no surface"
            text = "; ".join([text % (self.points, self.scans), *self.left_out.lines()])
            hint = "is --voxel_size right for the spacing of the points, and are the poses?"
            raise MeshMapError(text, hint)
        attributes = {OBSERVATIONS: found.observations}
        if found.intensities is not None:
            attributes[INTENSITY] = found.intensities
        mesh = Mesh(
            vertices=found.vertices,
            faces=found.faces,
            vertex_normals=found.normals,
            vertex_colors=found.colors,
            vertex_attributes=attributes,
            origin=(float(self.origin[0]), float(self.origin[1]), float(self.origin[2])),
        )
        return drivable(mesh, options, cancel)

    def stored(self) -> Tuple[Dict[str, Any], bytes]:
        """What json can write, and bytes: all that `restored` needs to go on.

        Raises:
            MeshMapError: there is no scan yet.
        """
        if self._field is None:
            raise MeshMapError("there is no scan, so there is nothing to go on with")
        values = {
            "options": self.options.stored(),
            "origin": self.origin.tolist(),
            "colors": self._colors,
            "intensities": self._intensities,
            "scans": self.scans,
            "points": self.points,
            "begun": list(self._begun),
            "left_out": self.left_out.stored(),
        }
        return values, self._field.to_bytes()

    @classmethod
    def restored(
        cls,
        values: Mapping[str, Any],
        data: bytes,
        memory_limit: Optional[int] = None,
        threads: int = 0,
    ) -> "Reconstruction":
        """As it was when `stored` was called.

        Raises:
            MeshMapError: what is stored is damaged, or of another version.
        """
        try:
            options = FieldOptions.of_stored(values["options"])
            made = cls(options, memory_limit, LeftOutCounts(values["left_out"]), threads)
            made.origin = np.array(values["origin"], np.float64).reshape(3)
            made.scans, made.points = int(values["scans"]), int(values["points"])
            name, count, done, report = values["begun"]
            made._begun = _Begun(str(name), int(count), int(done), IntegrationReport(*report))
            made._colors = bool(values["colors"])
            made._intensities = bool(values["intensities"])
            made._field = SignedDistanceField.from_bytes(
                data, memory_limit=memory_limit, threads=threads
            )
        except (KeyError, TypeError, ValueError) as error:
            raise MeshMapError(
                "what is stored of a reconstruction is damaged: %s" % error
            ) from error
        return made

    def _integrated(
        self, scan: Scan, colors: Optional[np.ndarray], intensities: Optional[np.ndarray]
    ) -> IntegrationReport:
        """What became of the points of a scan, which goes into the field piece by piece."""
        assert self._field is not None
        points, origins, count = scan.in_map(), scan.origins_in_map(), len(scan.points)
        if (self._begun.name, self._begun.count) != (scan.name, count):
            self._begun = _Begun(scan.name, count, 0, _NOTHING)
        for begin in range(self._begun.done, count, BATCH_POINTS):
            piece = slice(begin, begin + BATCH_POINTS)
            report = self._field.integrate(
                points[piece],
                origins if origins.ndim == 1 else origins[piece],
                colors=None if colors is None else colors[piece],
                intensities=None if intensities is None else intensities[piece],
            )
            done = min(count, begin + BATCH_POINTS)
            self._begun = _Begun(scan.name, count, done, self._begun.report + report)
        report = self._begun.report
        self._begun = _Begun("", 0, 0, _NOTHING)
        return report

    def _begin(self, first: Scan) -> None:
        options = self.options
        self._colors = first.colors is not None
        self._intensities = first.intensities is not None
        if options.origin is not None:
            self.origin = np.array(options.origin, np.float64)
        else:
            place = first.pose[:3, 3]
            if np.abs(place).max() * _ROUNDED > _FINE * options.voxel_size:
                self.origin = np.rint(place) + 0.0
        self._field = SignedDistanceField(
            voxel_size=options.voxel_size,
            truncation=options.truncation,
            max_range=options.max_range,
            min_range=options.min_range,
            carve=options.carve,
            memory_limit=self._memory_limit,
            colors=self._colors,
            intensities=self._intensities,
            threads=self._threads,
        )

    def _decimated(self, scan: Scan) -> Scan:
        """With the share of points that is wanted, evenly along their order."""
        share = self.options.decimate
        share = 1.0 / share if share > 1.0 else share
        if share == 1.0:
            return scan
        kept = math.ceil(len(scan.points) * share)
        which = np.minimum((np.arange(kept) / share).astype(np.int64), len(scan.points) - 1)
        arrays = {
            name: getattr(scan, name)[which]
            for name in ("points", "origins", "colors", "intensities")
            if getattr(scan, name) is not None
        }
        return replace(scan, **arrays)

    def _placed(self, scan: Scan) -> Optional[Scan]:
        """Relative to the origin; None where float32 has no room for that."""
        pose = np.array(scan.pose, np.float64)
        pose[:3, 3] -= self.origin
        far = float(np.abs(pose[:3, 3]).max())
        if not far * _ROUNDED <= _COARSE * self.options.voxel_size:
            text = "it is %.3g m from %s, where float32 rounds by more than a tenth of a voxel"
            reason = text % (far, self.origin.tolist())
            self.left_out.add("no_origin", scan.name, reason=reason)
            return None
        return replace(scan, pose=pose)

    def _channel(self, scan: Scan, name: str, wanted: bool) -> Optional[np.ndarray]:
        """Colors or intensities of a scan, where the field has such."""
        values: Optional[np.ndarray] = getattr(scan, name)
        if wanted and values is None:
            self.left_out.add("no_" + name, scan.name)
        if values is not None and not wanted:
            self.left_out.add("late_" + name, scan.name)
        return values if wanted else None
