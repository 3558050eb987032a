"""Writes textures, materials and texture coordinates, in hdf5_map_io's form or in LVR2's.

hdf5_map_io: everything in the group textures, the pictures as HDF5 images in textures/images.
LVR2 (up to 2024-11): every child of textures is a picture, [width,height,channels] with the rows of
the picture one after the other; texture_handles and rgb_color in materials, the rest in channels.
"""
from typing import Dict, Iterable

import h5py
import numpy as np

from mesh_msgs_hdf5.map_file.reading.material_reader import LVR2_COLORS, LVR2_TEXTURES
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.mesh import Materials

# HDF5 Image and Palette Specification 1.2, an image of 24 bits as H5IMmake_image_24bit makes it
IMAGE_ATTRIBUTES = {
    "CLASS": "IMAGE",
    "IMAGE_VERSION": "1.2",
    "IMAGE_SUBCLASS": "IMAGE_TRUECOLOR",
    "INTERLACE_MODE": "INTERLACE_PIXEL",
}
LVR2_MATERIALS = "materials"  # a group of the part
LVR2_FACE_MATERIALS = "face_material_indices"  # <u4 [F,1], a channel
LVR2_COORDINATES = "texture_coordinates"  # <f4 [V,2], a channel


def has_lvr2_form(part: h5py.Group) -> bool:
    """True if a part has textures or materials as LVR2 has them, and none as hdf5_map_io."""
    textures = part.get(schema.TEXTURES)
    if isinstance(textures, h5py.Group):
        ours = (schema.IMAGES, schema.MATERIALS, schema.FACE_MATERIALS, schema.TEXTURE_COORDINATES)
        if any(name in textures for name in ours):
            return False
        if any(name.isdigit() for name in textures):
            return True
    return isinstance(part.get(LVR2_MATERIALS), h5py.Group)


class TextureWriter:
    """Writes into one part. lvr2: in which form; channels: the group that LVR2 has for vertices and
    faces.
    """

    def __init__(
        self, writer: ObjectWriter, part: h5py.Group, lvr2: bool, channels: str = schema.CHANNELS
    ) -> None:
        self._writer = writer
        self._part = part
        self._lvr2 = lvr2
        self._channels = channels

    def textures(self, images: Dict[int, np.ndarray]) -> None:
        """Add images (height, width, channels) uint8; the places must be free."""
        for index, image in images.items():
            group = self._group(schema.TEXTURES)
            if not self._lvr2:
                group = self._writer.group(group, schema.IMAGES)
            height, width, channels = image.shape
            if self._lvr2:
                image = image.reshape(width, height, channels)
            stored = self._writer.array(group, str(index), image)
            if not self._lvr2:
                for name, text in IMAGE_ATTRIBUTES.items():
                    self._writer.c_text(stored, name, text)

    def remove_textures(self, indices: Iterable[int]) -> None:
        """Remove these images, in whichever form they are."""
        for textures in self._existing(schema.TEXTURES):
            for index in indices:
                self._writer.remove(textures, str(index))
                if isinstance(textures.get(schema.IMAGES), h5py.Group):
                    self._writer.remove(textures[schema.IMAGES], str(index))

    def coordinates(self, uv: np.ndarray) -> None:
        """Write (V, 2) float32."""
        if self._lvr2:
            self._writer.array(self._group(self._channels), LVR2_COORDINATES, uv)
        else:
            uvw = np.zeros((len(uv), 3), dtype=np.float32)
            uvw[:, :2] = uv
            name = schema.TEXTURE_COORDINATES
            self._writer.array(self._group(schema.TEXTURES), name, uvw.reshape(-1))

    def remove_coordinates(self) -> None:
        """Remove them, in whichever form they are."""
        self._remove(schema.TEXTURES, schema.TEXTURE_COORDINATES)
        self._remove(self._channels, LVR2_COORDINATES)

    def materials(self, materials: Materials) -> None:
        """Write them; the places must be free."""
        colors, indices = materials.colors, materials.texture_indices
        if self._lvr2:
            group = self._group(LVR2_MATERIALS)
            self._writer.array(group, LVR2_TEXTURES, indices)
            self._writer.array(group, LVR2_COLORS, colors.astype("<i2"))
            faces = materials.face_materials.reshape(-1, 1)
            self._writer.array(self._group(self._channels), LVR2_FACE_MATERIALS, faces)
        else:
            table = np.zeros(len(colors), dtype=schema.MATERIAL_DTYPE)
            table["textureIndex"] = indices
            table["r"], table["g"], table["b"] = colors.T
            group = self._group(schema.TEXTURES)
            self._writer.array(group, schema.MATERIALS, table)
            self._writer.array(group, schema.FACE_MATERIALS, materials.face_materials)

    def remove_materials(self) -> None:
        """Remove them, in whichever form they are."""
        for name in (schema.MATERIALS, schema.FACE_MATERIALS):
            self._remove(schema.TEXTURES, name)
        for name in (LVR2_TEXTURES, LVR2_COLORS):
            self._remove(LVR2_MATERIALS, name)
        self._remove(self._channels, LVR2_FACE_MATERIALS)

    def _group(self, name):
        return self._writer.group(self._part, name)

    def _existing(self, name):
        group = self._part.get(name)
        return [group] if isinstance(group, h5py.Group) else []

    def _remove(self, group_name, name):
        for group in self._existing(group_name):
            self._writer.remove(group, name)
