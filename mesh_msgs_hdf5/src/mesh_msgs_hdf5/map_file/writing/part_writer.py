"""Writes the members of a mesh into the group of a part, as schema S1 has them."""
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Dict, Optional, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import to_json
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter, free
from mesh_msgs_hdf5.map_file.writing.texture_writer import LVR2_MATERIALS, TextureWriter
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.label_names import TEXT, join_label, label_path
from mesh_msgs_hdf5.model.mesh import Features, Label, Mesh, geometry_uuid


class PartWriter:
    """Writes members (as check.checked_mesh returns them) into one part.

    Places must be free: what is to be replaced is removed first.
    """

    _vertex_values = schema.CHANNELS  # the group of layers and attributes

    def __init__(self, writer: ObjectWriter, part: h5py.Group, lvr2: bool = False) -> None:
        self._writer = writer
        self._part = part
        self._lvr2 = lvr2
        self.textures = TextureWriter(writer, part, lvr2)

    def mesh(self, mesh: Mesh) -> None:
        """Write everything."""
        for name, text in schema.LVR2_ATTRIBUTES.items():
            self._writer.attribute(self._part, name, text)
        self._structure()
        self.header(mesh.frame_id, mesh.origin, mesh.crs, mesh.source)
        with ThreadPoolExecutor(1) as pool:  # the hash takes a sixth of the time of saving
            uuid = pool.submit(geometry_uuid, mesh.vertices, mesh.faces)
            self._members(mesh)
        self._writer.text(self._part, schema.UUID, uuid.result())

    def _structure(self):
        """The groups that readers look for, and what says which schema it is."""
        for name in schema.GROUPS + ((LVR2_MATERIALS,) if self._lvr2 else ()):
            self._group(name)
        self._writer.attribute(self._part, schema.SCHEMA_VERSION, np.int32(schema.VERSION))

    def _members(self, mesh):
        for name, array in (
            (schema.VERTICES, mesh.vertices),
            (schema.FACES, mesh.faces),
            (schema.NORMALS, mesh.vertex_normals),
            (schema.COLORS, mesh.vertex_colors),
        ):
            if array is not None:
                self.channel(name, array)
        for name, costs in mesh.vertex_costs.items():
            self.layer(name, costs, mesh.layer_parameters.get(name))
        for name, values in mesh.vertex_attributes.items():
            self.vertex_attribute(name, values, mesh.vertex_parameters.get(name))
        for name, values in mesh.face_attributes.items():
            self.face_attribute(name, values, mesh.face_parameters.get(name))
        if mesh.texture_coordinates is not None:
            self.textures.coordinates(mesh.texture_coordinates)
        self.textures.textures(mesh.textures)
        if mesh.materials is not None:
            self.textures.materials(mesh.materials)
        for text, label in mesh.labels.items():
            self.label(text, label)
        if mesh.features is not None:
            self.features(mesh.features)
        if mesh.seam_originals is not None:
            self.seams(mesh.seam_originals, mesh.parent_uuid)

    def header(
        self,
        frame_id: Optional[str] = None,
        origin: Optional[Tuple[float, float, float]] = None,
        crs: Optional[str] = None,
        source: Optional[Dict[str, Any]] = None,
    ) -> None:
        """Set attributes of the part; None leaves one as it is. An origin of zeros and an empty
        crs are what a file means that does not say.
        """
        writer, part = self._writer, self._part
        if frame_id is not None:
            writer.text(part, schema.FRAME_ID, frame_id)
        if source is not None:
            writer.text(part, schema.SOURCE, to_json(writer.path, schema.SOURCE, source))
        if origin is not None:
            writer.remove_attribute(part, schema.ORIGIN)
            if any(origin):
                writer.attribute(part, schema.ORIGIN, np.array(origin, dtype="<f8"))
        if crs is not None:
            writer.remove_attribute(part, schema.CRS)
            if crs:
                writer.text(part, schema.CRS, crs)

    def channel(self, name: str, array: np.ndarray) -> None:
        """Write vertices, faces, normals or colors."""
        self._writer.array(self._group(schema.CHANNELS), name, array)

    def layer(self, name: str, costs: np.ndarray, parameters: Optional[Dict[str, Any]]) -> None:
        """Write (V,) costs."""
        stored = self._writer.array(self._group(self._vertex_values), name, costs.reshape(-1, 1))
        self.parameters(stored, parameters)

    def vertex_attribute(
        self, name: str, values: np.ndarray, parameters: Optional[Dict[str, Any]]
    ) -> None:
        """Write (V,) or (V, C) numbers, marked where they look like a layer."""
        rows = values.reshape(len(values), -1)
        stored = self._writer.array(self._group(self._vertex_values), name, rows)
        if rows.shape[1] == 1 and values.dtype.kind == "f":
            self._writer.text(stored, schema.KIND, schema.ATTRIBUTE)
        self.parameters(stored, parameters)

    def face_attribute(
        self, name: str, values: np.ndarray, parameters: Optional[Dict[str, Any]]
    ) -> None:
        """Write (F,) or (F, C) numbers."""
        stored = self._writer.array(self._group(schema.FACE_ATTRIBUTES), name, values)
        self.parameters(stored, parameters)

    def parameters(self, dataset: h5py.Dataset, parameters: Optional[Dict[str, Any]]) -> None:
        """Set the parameters of a layer or attribute; none if empty."""
        self._writer.remove_attribute(dataset, schema.PARAMETERS)
        if parameters:
            what = "%s of %s" % (schema.PARAMETERS, dataset.name)
            text = to_json(self._writer.path, what, parameters)
            self._writer.text(dataset, schema.PARAMETERS, text)

    def label(self, text: str, label: Label, place: Optional[Tuple[str, str]] = None) -> None:
        """Write a label; place: (group, dataset) where the file had it, else where it belongs."""
        labels = self._group(schema.LABELS)
        group_name, name = place or label_path(text)[:2]
        if not isinstance(labels.get(group_name, labels), h5py.Group):
            group_name = free(labels, group_name)
        group = self._writer.group(labels, group_name)
        name = free(group, name)  # "grass" and "grass_" have the same path
        stored = self._writer.array(group, name, self._label_faces(label), many=True)
        if join_label(group_name, name) != text:
            self._writer.text(stored, TEXT, text)
        if label.color is not None:
            color = np.array(label.color, dtype=np.uint8)
            self._writer.attribute(stored, schema.LABEL_COLOR, color)

    def _label_faces(self, label):
        return label.faces

    def features(self, features: Features) -> None:
        """Write all features, each a dataset."""
        group = self._writer.group(self._group(schema.CHANNELS), schema.FEATURES)
        for index, (place, descriptor) in enumerate(zip(features.locations, features.descriptors)):
            stored = self._writer.array(group, str(index), descriptor, many=True)
            self._writer.attribute(stored, schema.FEATURE_LOCATION, place)

    def seams(self, originals: np.ndarray, parent_uuid: str) -> None:
        """Write the table of copies, and what the mesh without them is."""
        stored = self._writer.array(self._group(schema.SEAMS), schema.ORIGINALS, originals)
        self._writer.text(stored, schema.PARENT_UUID, parent_uuid)

    def _group(self, name):
        return self._writer.group(self._part, name)
