"""Reads the materials of faces, in the form of hdf5_map_io or in LVR2's."""
from typing import Collection, List, Optional

import numpy as np

from mesh_msgs_hdf5.checks.check import checked_materials
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import check_shape
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import exists
from mesh_msgs_hdf5.map_file.reading.part_reader import PartReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Materials

MAX_MATERIALS = 1 << 20
LVR2_TEXTURES = "texture_handles"  # <i4 [M], -1 for none
LVR2_COLORS = "rgb_color"  # <i2 [M,3], -1 for none
_NAMES = tuple(schema.MATERIAL_DTYPE.names)


class MaterialReader(PartReader):
    """The materials of a part. A part has some only if it says which face is of which."""

    face_count: int

    def texture_indices(self) -> List[int]:
        """Those that materials may name."""
        raise NotImplementedError

    def material_places(self) -> List[str]:
        """Where the materials are: [materials, those of the faces], or LVR2's [textures, colors,
        those of the faces]; [] if there are none.
        """
        textures, lvr2 = self.layout.textures, self.layout.lvr2_materials
        forms = [(textures, schema.MATERIALS, schema.FACE_MATERIALS)] if textures else []
        forms += [(lvr2, LVR2_TEXTURES, LVR2_COLORS)] if lvr2 else []
        for group, *names in forms:
            found = ["%s/%s" % (group, name) for name in names]
            found += [self.layout.lvr2_face_materials] if group == lvr2 else []
            if all(exists(self.guarded.group, place) for place in found):
                return found
        return []

    @property
    def materials(self) -> Optional[Materials]:
        """What the faces are made of; None if the file does not say it of each face, or not so
        that it can be read. A material whose texture is not there is one without; a face whose
        material is not there is white."""
        return self.tolerated(self._materials, None)

    def _materials(self):
        datasets = [self.guarded.dataset(place, fields=True) for place in self.material_places()]
        if not datasets:
            return None
        path = self.guarded.path
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
        check_shape(path, datasets[-1], 1, self.face_count)
        faces = self.guarded.values(datasets[-1]).reshape(-1)
        found = Materials(colors, indices, faces)
        if not self.strict:
            found = self._with_one_for_each(found)
            self.without_textures(found, self.texture_indices())
        return checked_materials(path, found, self.face_count, self.texture_indices())

    def _with_one_for_each(self, materials: Materials) -> Materials:
        """Faces whose material is not there get a white one, with a note."""
        faces, count = materials.face_materials, len(materials.colors)
        if faces.dtype.kind not in "iu":
            return materials
        wrong = (faces < 0) | (faces >= count)
        if not wrong.any() or wrong.all():
            return materials
        text = "left out: the materials of %d faces, which are white: face %d refers to material %d"
        first = wrong.argmax()
        self.note((text + " of %d") % (np.count_nonzero(wrong), first, faces[first], count))
        return Materials(
            np.append(materials.colors, np.full((1, 3), 255, np.uint8), axis=0),
            np.append(materials.texture_indices, np.int32(-1)),
            np.where(wrong, count, faces.astype(np.int64)),
        )

    def without_textures(self, materials: Materials, there: Collection[int]) -> None:
        """Take the textures that are not there away from materials; a note says so."""
        indices = materials.texture_indices
        lost = (indices != -1) & ~np.isin(indices, np.array(sorted(there), dtype=np.int64))
        if lost.any():
            text = "left out: the textures of %d materials, which are not there; first material %d"
            self.note((text + " with texture %d") % (lost.sum(), lost.argmax(), indices[lost][0]))
            materials.texture_indices = np.where(lost, -1, indices).astype(np.int32)

    def _compound(self, found):
        """(colors, texture indices) of a compound, whatever its fields' order and widths."""
        path = self.guarded.path
        check_shape(path, found, 1)
        if not set(_NAMES) <= set(found.dtype.names or ()):
            raise MapFileError(
                "dtype",
                path,
                "%s has the fields %s" % (found.name, ", ".join(found.dtype.names or ("none",))),
                "materials have the fields %s" % ", ".join(_NAMES),
            )
        values = self.guarded.values(found).reshape(-1)
        texture, *colors = (
            to_exact(
                values[name], schema.MATERIAL_DTYPE[name], path, "%s of %s" % (name, found.name)
            )
            for name in _NAMES
        )
        return np.stack(colors, axis=1), texture

    def _of_lvr2(self, textures, colors):
        """The same of LVR2's; white where it says -1: a material without a color of its own."""
        path = self.guarded.path
        check_shape(path, textures, 1)
        check_shape(path, colors, 3, textures.size)
        rgb = to_exact(self.guarded.values(colors), "<i8", path, colors.name).reshape(-1, 3)
        rgb = np.where((rgb == -1).all(axis=1, keepdims=True), 255, rgb)
        rgb = to_exact(rgb, "|u1", path, colors.name)
        indices = to_exact(self.guarded.values(textures), "<i4", path, textures.name)
        return rgb, indices.reshape(-1)
