"""Reads vertices, faces, normals and colors of a part."""
from functools import cached_property
from typing import List, Optional

import numpy as np

from mesh_msgs_hdf5.checks.check import check_faces, check_finite
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import check_shape
from mesh_msgs_hdf5.map_file.reading.part_reader import PartReader
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mending import mended_normals


class GeometryReader(PartReader):
    """The geometry of a part and what each of its vertices has. Counting reads shapes only."""

    @cached_property
    def vertex_count(self) -> int:
        """V, of which nothing but the shape is looked at."""
        return self._rows(self.layout.vertices)

    @cached_property
    def face_count(self) -> int:
        """F, likewise."""
        return self._rows(self.layout.faces)

    def _rows(self, place):
        found = self.guarded.dataset(place)
        if found is None:
            raise MapFileError(
                "no_mesh",
                self.guarded.path,
                "%s/%s is missing" % (self.guarded.group.name.rstrip("/"), place),
                "is it a mesh map?",
            )
        check_shape(self.guarded.path, found, 3)
        return int(found.size) // 3

    def geometry_places(self) -> List[str]:
        """Where vertices, faces and, if there are any, normals and colors are."""
        first, layout = self.guarded.first, self.layout
        return [layout.vertices, layout.faces] + first(layout.normals) + first(layout.colors)

    @property
    def has_normals(self) -> bool:
        """True if something is where normals are."""
        return bool(self.guarded.first(self.layout.normals))

    @property
    def has_colors(self) -> bool:
        """True if something is where colors are."""
        return bool(self.guarded.first(self.layout.colors))

    @property
    def vertices(self) -> np.ndarray:
        """(V, 3) float32, meters in frame_id; finite. Wider floats are rounded, with a note."""
        found = self.guarded.dataset(self.layout.vertices)
        values = self.float32(self._vectors(found, None), found.name)
        check_finite(self.guarded.path, found.name, values)
        return values

    @property
    def vertex_rounding(self) -> float:
        """By how much (meters) rounding changes a coordinate at most; nothing is read of float32.

        Far from the origin float32 is coarse: see mesh_msgs.checks.rounding.is_too_much.
        """
        found = self.guarded.dataset(self.layout.vertices)
        if self.strict or found.dtype.kind != "f" or found.dtype.itemsize <= 4:
            return 0.0
        values = self._vectors(found, None)
        return (
            float(np.abs(self.float32(values, found.name) - values).max()) if len(values) else 0.0
        )

    @property
    def vertex_normals(self) -> Optional[np.ndarray]:
        """(V, 3) float32, finite; None if the file has none that can be read."""
        return self.tolerated(self._normals, None)

    def _normals(self):
        found = self.guarded.first_dataset(self.layout.normals)
        if found is None:
            return None
        values = self.float32(self._vectors(found, self.vertex_count), found.name)
        bad = ~np.isfinite(values).all(axis=1)
        if bad.any() and (self.strict or bad.all()):
            check_finite(self.guarded.path, found.name, values)
        if bad.any():
            values = mended_normals(values, bad, self.vertices, self.faces)
            text = "%d normals of %s are not finite: made anew from the faces there, first row %d"
            self.note(text % (np.count_nonzero(bad), found.name, bad.argmax()))
        return values

    def _vectors(self, found, rows):
        columns = check_shape(self.guarded.path, found, 3, rows)
        return self.guarded.values(found).reshape(-1, columns)

    @property
    def faces(self) -> np.ndarray:
        """(F, 3) uint32, each below V."""
        found = self.guarded.dataset(self.layout.faces)
        values = self.guarded.values(found).reshape(-1, 3)
        if values.dtype.kind in "iu":
            # before conversion: -1 is a wrong index, not a value that does not fit
            check_faces(self.guarded.path, values, self.vertex_count)
        return to_exact(values, "<u4", self.guarded.path, found.name)

    @property
    def vertex_colors(self) -> Optional[np.ndarray]:
        """(V, 3) uint8 red, green, blue; None if the file has none that can be read.

        A fourth value, alpha, is left out; that is noted where it does not say that all is opaque.
        """
        return self.tolerated(self._colors, None)

    def _colors(self):
        found = self.guarded.first_dataset(self.layout.colors)
        if found is None:
            return None
        columns = check_shape(self.guarded.path, found, (3, 4), self.vertex_count)
        values = self.guarded.values(found).reshape(-1, columns)
        if columns == 4:
            values = self._opaque(found.name, values)
        return to_exact(values, "|u1", self.guarded.path, found.name)

    def _opaque(self, name, values):
        alpha = values[:, 3] != 255
        if alpha.any():
            text = "%s has an alpha other than 255 in row %d, %d in all"
            text %= name, alpha.argmax(), np.count_nonzero(alpha)
            if self.strict:
                hint = "vertex colors are opaque: store red, green and blue"
                raise MapFileError("value", self.guarded.path, text, hint)
            self.note("left out: alpha; " + text)
        return np.ascontiguousarray(values[:, :3])
