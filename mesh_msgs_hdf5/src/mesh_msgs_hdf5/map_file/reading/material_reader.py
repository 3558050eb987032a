"""Reads the materials of faces, in the form of hdf5_map_io or in LVR2's."""
from typing import Collection, List, Optional

import numpy as np

from mesh_msgs_hdf5.checks.check import checked_materials
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup, check_shape
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import exists
from mesh_msgs_hdf5.map_file.reading.layouts import Layout
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Materials

MAX_MATERIALS = 1 << 20
LVR2_TEXTURES = "texture_handles"  # <i4 [M], -1 for none
LVR2_COLORS = "rgb_color"  # <i2 [M,3], -1 for none
_NAMES = tuple(schema.MATERIAL_DTYPE.names)


class MaterialReader:
    """The materials of a part. A part has some only if it says which face is of which."""

    def __init__(self, part: GuardedGroup, layout: Layout, face_count: int) -> None:
        self._part = part
        self._layout = layout
        self._face_count = face_count

    def places(self) -> List[str]:
        """Where the materials are: [materials, those of the faces], or LVR2's [textures, colors,
        those of the faces]; [] if there are none.
        """
        textures, lvr2 = self._layout.textures, self._layout.lvr2_materials
        forms = [(textures, schema.MATERIALS, schema.FACE_MATERIALS)] if textures else []
        forms += [(lvr2, LVR2_TEXTURES, LVR2_COLORS)] if lvr2 else []
        for group, *names in forms:
            found = ["%s/%s" % (group, name) for name in names]
            found += [self._layout.lvr2_face_materials] if group == lvr2 else []
            if all(exists(self._part.group, place) for place in found):
                return found
        return []

    def materials(self, textures: Collection[int]) -> Optional[Materials]:
        """The materials; each names one of these textures or none. None if there are none."""
        datasets = [self._part.dataset(place, fields=True) for place in self.places()]
        if not datasets:
            return None
        path = self._part.path
        for found in datasets:
            if found is not datasets[-1] and len(found.shape) and len(found) > MAX_MATERIALS:
                raise MapFileError(
                    "size",
                    path,
                    "%s has %d materials, more than the %d allowed"
                    % (found.name, len(found), MAX_MATERIALS),
                    "is it a mesh map?",
                )
        read = self._compound if len(datasets) == 2 else self._of_lvr2
        colors, indices = read(*datasets[:-1])
        check_shape(path, datasets[-1], 1, self._face_count)
        faces = self._part.values(datasets[-1]).reshape(-1)
        return checked_materials(
            path, Materials(colors, indices, faces), self._face_count, textures
        )

    def _compound(self, found):
        """(colors, texture indices) of a compound, whatever its fields' order and widths."""
        path = self._part.path
        check_shape(path, found, 1)
        if not set(_NAMES) <= set(found.dtype.names or ()):
            raise MapFileError(
                "dtype",
                path,
                "%s has the fields %s" % (found.name, ", ".join(found.dtype.names or ("none",))),
                "materials have the fields %s" % ", ".join(_NAMES),
            )
        values = self._part.values(found).reshape(-1)
        texture, *colors = (
            to_exact(
                values[name], schema.MATERIAL_DTYPE[name], path, "%s of %s" % (name, found.name)
            )
            for name in _NAMES
        )
        return np.stack(colors, axis=1), texture

    def _of_lvr2(self, textures, colors):
        """The same of LVR2's; white where it says -1: a material without a color of its own."""
        path = self._part.path
        check_shape(path, textures, 1)
        check_shape(path, colors, 3, textures.size)
        rgb = to_exact(self._part.values(colors), "<i8", path, colors.name).reshape(-1, 3)
        rgb = np.where((rgb == -1).all(axis=1, keepdims=True), 255, rgb)
        rgb = to_exact(rgb, "|u1", path, colors.name)
        indices = to_exact(self._part.values(textures), "<i4", path, textures.name)
        return rgb, indices.reshape(-1)
