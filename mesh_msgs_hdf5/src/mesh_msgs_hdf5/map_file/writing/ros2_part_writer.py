"""Writes the members of a mesh into the group of a part, as schema S2 has them.

LVR2 since 2024-12 and the mesh tools of ROS 2 read it: mesh_map what is in vertex_attributes and
face_attributes, RViz's Map3D normals and colors in geometry. What S2 has no place for (the frame,
texts and colors of labels, features, ...) stands where S1 has it; those programs do not look there.
"""
from typing import Any, Dict, Optional

import h5py
import numpy as np

from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter
from mesh_msgs_hdf5.map_file.writing.part_writer import PartWriter
from mesh_msgs_hdf5.map_file.writing.texture_writer import TextureWriter
from mesh_msgs_hdf5.model import schema

_GEOMETRY = "geometry"
_VERTEX_ATTRIBUTES = "vertex_attributes"
# without these, LVR2's PointCloudIO, with which Map3D reads the layers, takes the group for none
_POINTS = {"IO": "PointCloudIO", "CLASS": "PointBuffer"}


class Ros2PartWriter(PartWriter):
    """Writes members (as check.checked_mesh returns them) into one part; places must be free.

    Every array has two dimensions, for LVR2 asks each for its second one.
    """

    _vertex_values = _VERTEX_ATTRIBUTES

    def __init__(self, writer: ObjectWriter, part: h5py.Group) -> None:
        super().__init__(writer, part)
        self.textures = TextureWriter(writer, part, lvr2=True, channels=_GEOMETRY)

    def _structure(self):
        for name in (_GEOMETRY, schema.FACE_ATTRIBUTES, schema.LABELS):
            self._group(name)
        attributes = self._group(_VERTEX_ATTRIBUTES)
        for name, text in _POINTS.items():
            self._writer.attribute(attributes, name, text)

    def channel(self, name: str, array: np.ndarray) -> None:
        """Normals and colors are stored once, under two names."""
        if name not in (schema.NORMALS, schema.COLORS):
            self._writer.array(self._group(_GEOMETRY), name, array)
            return
        stored = self._writer.array(self._group(_VERTEX_ATTRIBUTES), name, array)
        self._writer.further_name(stored, self._group(_GEOMETRY), name)

    def face_attribute(
        self, name: str, values: np.ndarray, parameters: Optional[Dict[str, Any]]
    ) -> None:
        """Write (F,) or (F, C) numbers."""
        super().face_attribute(name, values.reshape(len(values), -1), parameters)

    def _label_faces(self, label):
        return label.faces.reshape(-1, 1)


def remove_vertex_attributes(writer: ObjectWriter, part: Optional[h5py.Group]) -> None:
    """Remove the group of a part of schema S2 if it says no more than that it is one of points."""
    group = part.get(_VERTEX_ATTRIBUTES) if part is not None else None
    if isinstance(group, h5py.Group) and not len(group) and set(group.attrs) <= set(_POINTS):
        writer.remove(part, _VERTEX_ATTRIBUTES)
