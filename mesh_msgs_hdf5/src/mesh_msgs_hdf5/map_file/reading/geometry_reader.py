"""Reads vertices, faces, normals and colors of a part."""
from functools import cached_property
from typing import List, Optional

import numpy as np

from mesh_msgs_hdf5.checks.check import check_faces, check_finite
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup, check_shape
from mesh_msgs_hdf5.map_file.reading.layouts import Layout
from mesh_msgs_hdf5.model.errors import MapFileError


class GeometryReader:
    """The geometry of a part and what each of its vertices has. Counting reads shapes only."""

    def __init__(self, part: GuardedGroup, layout: Layout) -> None:
        self._part = part
        self._layout = layout

    @cached_property
    def vertex_count(self) -> int:
        """V, of which nothing but the shape is looked at."""
        return self._rows(self._layout.vertices)

    @cached_property
    def face_count(self) -> int:
        """F, likewise."""
        return self._rows(self._layout.faces)

    def _rows(self, place):
        found = self._part.dataset(place)
        if found is None:
            raise MapFileError(
                "no_mesh",
                self._part.path,
                "%s/%s is missing" % (self._part.group.name.rstrip("/"), place),
                "is it a mesh map?",
            )
        check_shape(self._part.path, found, 3)
        return int(found.size) // 3

    def places(self) -> List[str]:
        """Where vertices, faces and, if there are any, normals and colors are."""
        first, layout = self._part.first, self._layout
        return [layout.vertices, layout.faces] + first(layout.normals) + first(layout.colors)

    def has_normals(self) -> bool:
        """True if something is where normals are."""
        return bool(self._part.first(self._layout.normals))

    def has_colors(self) -> bool:
        """True if something is where colors are."""
        return bool(self._part.first(self._layout.colors))

    def vertices(self) -> np.ndarray:
        """(V, 3) float32, finite."""
        return self._vectors(self._part.dataset(self._layout.vertices), None)

    def normals(self) -> Optional[np.ndarray]:
        """(V, 3) float32, finite; None if there are none."""
        found = self._part.first_dataset(self._layout.normals)
        return None if found is None else self._vectors(found, self.vertex_count)

    def _vectors(self, found, rows):
        columns = check_shape(self._part.path, found, 3, rows)
        values = self._part.values(found).reshape(-1, columns)
        values = to_exact(values, "<f4", self._part.path, found.name)
        check_finite(self._part.path, found.name, values)
        return values

    def faces(self) -> np.ndarray:
        """(F, 3) uint32, each below V."""
        found = self._part.dataset(self._layout.faces)
        values = self._part.values(found).reshape(-1, 3)
        if values.dtype.kind in "iu":
            # before conversion: -1 is a wrong index, not a value that does not fit
            check_faces(self._part.path, values, self.vertex_count)
        return to_exact(values, "<u4", self._part.path, found.name)

    def colors(self) -> Optional[np.ndarray]:
        """(V, 3) uint8; None if there are none. A fourth value must say that all is opaque."""
        found = self._part.first_dataset(self._layout.colors)
        if found is None:
            return None
        columns = check_shape(self._part.path, found, (3, 4), self.vertex_count)
        values = self._part.values(found).reshape(-1, columns)
        if columns == 4:
            values = self._opaque(found.name, values)
        return to_exact(values, "|u1", self._part.path, found.name)

    def _opaque(self, name, values):
        alpha = values[:, 3] != 255
        if alpha.any():
            raise MapFileError(
                "value",
                self._part.path,
                "%s has an alpha other than 255 in row %d, %d in all"
                % (name, np.flatnonzero(alpha)[0], np.count_nonzero(alpha)),
                "vertex colors are opaque: store red, green and blue",
            )
        return np.ascontiguousarray(values[:, :3])
