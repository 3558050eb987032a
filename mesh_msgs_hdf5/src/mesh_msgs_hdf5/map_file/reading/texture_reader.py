"""Reads textures, in the form of hdf5_map_io (HDF5 images) or in LVR2's, as a part has them."""
from functools import cached_property
from typing import List, Optional

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import checked_image, checked_texture_coordinates
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import check_shape
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import exists, is_group_of_this_file
from mesh_msgs_hdf5.map_file.reading.part_reader import PartReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mending import mended_coordinates

MAX_TEXTURES = 10_000
_MAX_INDEX = (1 << 31) - 1
# where the planes are: https://docs.hdfgroup.org/hdf5/v1_14/_i_m_g.html (HDF5 Image and Palette
# Specification 1.2, INTERLACE_MODE); the axis of the colors
_PLANES = {"INTERLACE_PIXEL": 2, "INTERLACE_LINE": 1, "INTERLACE_PLANE": 0}
_GRAY = ("IMAGE_GRAYSCALE", "IMAGE_INDEXED")


class TextureReader(PartReader):
    """The textures and texture coordinates of a part."""

    vertex_count: int
    faces: np.ndarray

    @property
    def textures_form(self) -> str:
        """Whose form textures and materials have: hdf5_map_io, lvr2, or "" where there are none.

        LVR2's MeshIO cannot read a mesh with those of hdf5_map_io.
        """
        return self.tolerated(self._textures_form, "")

    def _textures_form(self):
        textures = self.layout.textures
        group = self.guarded.subgroup(textures) if textures else None
        if group is None:
            return ""
        if any(exists(group, name) for name in (schema.IMAGES, schema.MATERIALS)):
            return "hdf5_map_io"
        return "lvr2" if self._indices else ""

    def texture_places(self) -> List[str]:
        """Where texture coordinates and textures are."""
        place = self.tolerated(self._images_place, "")
        found = self.guarded.first(self.layout.texture_coordinates)
        return found + ["%s/%d" % (place, index) for index in self.texture_indices()]

    @property
    def texture_coordinates(self) -> Optional[np.ndarray]:
        """(V, 2) float32 u, v; None if the file has none that can be read.

        The third value that hdf5_map_io stores is left out, and stays in the file.
        """
        return self.tolerated(self._texture_coordinates, None)

    def _texture_coordinates(self):
        found = self.guarded.first_dataset(self.layout.texture_coordinates)
        if found is None:
            return None
        columns = check_shape(self.guarded.path, found, (3, 2), self.vertex_count)
        values = self.guarded.values(found).reshape(-1, columns)[:, :2]
        values = self.float32(values, "texture coordinates")
        bad = ~np.isfinite(values).all(axis=1)
        if bad.any() and not bad.all() and not self.strict:
            values = mended_coordinates(values, bad, self.faces)
            text = "%d texture coordinates are not finite: the mean of those beside them, first"
            self.note((text + " vertex %d") % (np.count_nonzero(bad), bad.argmax()))
        return checked_texture_coordinates(self.guarded.path, values, self.vertex_count)

    def texture_indices(self) -> List[int]:
        """The indices of the textures, ascending. The file is looked through once.

        They are decimal numbers without leading zeros; what has another name is no texture.
        """
        return list(self._indices)

    @cached_property
    def _indices(self):
        return self.tolerated(self._found_indices, [])

    def _found_indices(self):
        place = self._images_place()
        names = self.guarded.dataset_names(place, MAX_TEXTURES) if place else []
        return sorted(int(name) for name in names if _is_index(name))

    def texture(self, index: int) -> np.ndarray:
        """(height, width, 3) uint8, or (height, width, 4) with alpha; row 0 is the top.

        Gray images become red, green and blue.
        """
        part = self.guarded
        known = self.texture_indices()
        if index not in known:
            raise MapFileError(
                "index",
                part.path,
                "there is no texture %s" % (index,),
                "textures of this file: %s" % (", ".join(map(str, known)) or "none"),
            )
        place = self._images_place()
        found = part.dataset("%s/%d" % (place, index))
        if place != self.layout.textures:
            return checked_image(part.path, index, _colored(self._image(found)))
        if found.ndim != 3 or not found.size:
            raise self._no_image(found)
        # LVR2 stores the rows of the image one after the other, but declares its width first
        width, height, planes = found.shape
        pixels = part.values(found).reshape(height, width, planes)
        return checked_image(part.path, index, _colored(pixels))

    def _images_place(self):
        """The group of the images; "" if there is none."""
        textures = self.layout.textures
        group = self.guarded.subgroup(textures) if textures else None
        if group is None:
            return ""
        if is_group_of_this_file(group, schema.IMAGES):
            return textures + "/" + schema.IMAGES
        return textures if self.layout.lvr2_materials else ""

    def _image(self, found):
        """The planes of an HDF5 image as (height, width, planes)."""
        path = self.guarded.path
        kind = attribute(path, found, "IMAGE_SUBCLASS")
        if h5py.h5a.exists(found.id, b"PALETTE") or kind not in (None, "IMAGE_TRUECOLOR") + _GRAY:
            raise MapFileError(
                "value",
                path,
                "%s is an image with a palette or of the unknown kind %s" % (found.name, kind),
                "store red, green and blue of each pixel",
            )
        if found.ndim == 2 and kind != "IMAGE_TRUECOLOR" and found.size:
            return self._gray(found)[:, :, np.newaxis]
        mode = attribute(path, found, "INTERLACE_MODE")
        axis = _PLANES.get(mode if mode is not None else "INTERLACE_PIXEL")
        if found.ndim != 3 or axis is None or not found.size or found.shape[axis] not in (3, 4):
            raise self._no_image(found)
        return np.moveaxis(self.guarded.values(found), axis, 2)

    def _gray(self, found):
        values = self.guarded.values(found)
        if attribute(self.guarded.path, found, "IMAGE_WHITE_IS_ZERO") not in (None, 0):
            if values.dtype != np.uint8:
                raise self._no_image(found)
            values = 255 - values
        return values

    def _no_image(self, found):
        return MapFileError(
            "shape",
            self.guarded.path,
            "%s has the shape %s and type %s: no image of 8-bit red, green and blue"
            % (found.name, list(found.shape), found.dtype),
            "[height,width,3], as the HDF5 Image specification has it",
        )


def _is_index(name):
    plain = name.isascii() and name.isdigit() and len(name) <= 10
    return plain and str(int(name)) == name and int(name) <= _MAX_INDEX


def _colored(pixels):
    """Gray as red, green and blue."""
    return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels
