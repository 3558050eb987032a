"""Reads one part of an open map file, one object at a time."""
from typing import Any, Dict, List, Optional, Union

import h5py
import numpy as np

from mesh_msgs_hdf5 import schema
from mesh_msgs_hdf5.check import check_faces, check_finite, checked_costs, from_json, shaped
from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.exact import to_exact
from mesh_msgs_hdf5.hdf5_guard import (
    attribute,
    children,
    child,
    dataset,
    default_budget,
    is_group_of_this_file,
    join,
    subgroup,
)
from mesh_msgs_hdf5.mesh import Mesh


class MapReader:
    """One part of an open h5py.File. Opening reads names, shapes and attributes, no arrays.

    Every method raises MapFileError (with the given path) where the file is not sound.
    """

    def __init__(
        self, file: h5py.File, path: PathLike, part: str, budget: Optional[int] = None
    ) -> None:
        self.path = path
        self.budget = budget or default_budget()
        group = file
        for name in schema.part_path(path, part):
            group = subgroup(path, group, name) if group is not None else None
        self.channels = None if group is None else subgroup(path, group, schema.CHANNELS)
        if self.channels is None:
            known = parts(file, path)
            raise MapFileError(
                "part" if known else "no_mesh",
                path,
                "there is no mesh in /%s (schema S1: /%s/channels/vertices)"
                % ((part.strip("/"),) * 2),
                "parts of this file: %s" % ", ".join(known) if known else "is it a mesh map?",
            )
        self.group = group
        self.vertex_count = self._rows(schema.VERTICES)
        self.face_count = self._rows(schema.FACES)

    def _rows(self, name):
        columns = schema.ARRAYS[name][0]
        found = dataset(self.path, self.channels, name, self.budget)
        if found is None:
            raise MapFileError(
                "no_mesh",
                self.path,
                "%s is missing" % join(self.channels, name),
                "is it a mesh map?",
            )
        if not (found.ndim == 1 and found.size % columns == 0) and found.shape[1:] != (columns,):
            raise MapFileError(
                "shape", self.path, "%s has the shape %s" % (found.name, list(found.shape)), ""
            )
        return found.size // columns

    def has(self, name: str) -> bool:
        """True if there is a channel of that name."""
        return child(self.path, self.channels, name) is not None

    def array(self, name: str) -> Optional[np.ndarray]:
        """vertices, face_indices, vertex_normals or vertex_colors in the schema's type, checked.

        None if absent.
        """
        columns, dtype = schema.ARRAYS[name]
        found = dataset(self.path, self.channels, name, self.budget)
        if found is None:
            return None
        rows = self.face_count if name == schema.FACES else self.vertex_count
        if name == schema.COLORS and found.shape == (rows, 4):
            values = self._opaque(found)
        else:
            values = shaped(self.path, found.name, found[()], columns, rows)
        if name == schema.FACES and values.dtype.kind in "iu":
            check_faces(self.path, values, self.vertex_count)
        values = np.ascontiguousarray(to_exact(values, dtype, self.path, found.name))
        if values.dtype.kind == "f":
            check_finite(self.path, found.name, values)
        return values

    def _opaque(self, found):
        values = found[()]
        alpha = values[:, 3] != 255
        if alpha.any():
            raise MapFileError(
                "value",
                self.path,
                "%s has an alpha other than 255 in row %d, %d in all"
                % (found.name, np.flatnonzero(alpha)[0], np.count_nonzero(alpha)),
                "vertex colors are opaque: store red, green and blue",
            )
        return values[:, :3]

    def layer_names(self) -> List[str]:
        """The cost layers: float channels with one value per vertex that are not mesh data.

        Sorted.
        """
        names = children(self.path, self.channels)
        return [name for name in names if self._is_layer(name, names)]

    def _is_layer(self, name, names):
        if name in schema.RESERVED or name.endswith("_idx") or name + "_idx" in names:
            return False
        key = name.encode("utf-8")
        if self.channels.id.links.get_info(key).type != h5py.h5l.TYPE_HARD:
            return False  # a link is not followed, so it is no layer
        found = self.channels[name]
        if not isinstance(found, h5py.Dataset) or found.dtype.kind != "f":
            return False
        return found.shape in ((self.vertex_count,), (self.vertex_count, 1))

    def layer(self, name: str) -> np.ndarray:
        """The costs of a layer: (V,) float32."""
        found = self._layer_dataset(name)
        return checked_costs(self.path, name, found[()], self.vertex_count)

    def layer_parameters(self, name: str) -> Dict[str, Any]:
        """The parameters a layer was computed with; {} if the file does not say."""
        found = self._layer_dataset(name)
        text = attribute(self.path, found, schema.PARAMETERS)
        return from_json(self.path, "%s of %s" % (schema.PARAMETERS, found.name), text)

    def _layer_dataset(self, name):
        known = self.layer_names()
        if name not in known:
            raise MapFileError(
                "layer",
                self.path,
                "there is no layer %r" % name,
                "layers of this file: %s" % (", ".join(known) or "none"),
            )
        return dataset(self.path, self.channels, name, self.budget)

    def attribute(self, name: str) -> Union[str, int, float, None]:
        """The value of an attribute of the part's group; None if there is none."""
        return attribute(self.path, self.group, name)

    def text(self, name: str, default: Optional[str] = None) -> Optional[str]:
        """The same, refused if it is not a text."""
        value = self.attribute(name)
        if value is not None and not isinstance(value, str):
            raise MapFileError("value", self.path, "attribute %s is not a text" % name, "")
        return default if value is None else value

    def schema_version(self) -> int:
        """0 for a file that does not say (LVR2, mesh_tools 1.x)."""
        value = self.attribute(schema.SCHEMA_VERSION)
        if value is not None and (not isinstance(value, int) or value < 0):
            raise MapFileError("value", self.path, "%s is %r" % (schema.SCHEMA_VERSION, value), "")
        return value or 0

    def frame_id(self) -> str:
        """The frame of the vertices; "map" for a file that does not say."""
        frame_id = self.text(schema.FRAME_ID, "map")
        schema.check_frame_id(self.path, frame_id)
        return frame_id

    def source(self) -> Dict[str, Any]:
        """Provenance; {} for a file that does not say."""
        return from_json(self.path, "attribute " + schema.SOURCE, self.text(schema.SOURCE))

    def mesh(self) -> Mesh:
        """Everything as one Mesh."""
        names = self.layer_names()
        parameters = {name: self.layer_parameters(name) for name in names}
        return Mesh(
            vertices=self.array(schema.VERTICES),
            faces=self.array(schema.FACES),
            vertex_normals=self.array(schema.NORMALS),
            vertex_colors=self.array(schema.COLORS),
            vertex_costs={name: self.layer(name) for name in names},
            frame_id=self.frame_id(),
            source=self.source(),
            layer_parameters={name: value for name, value in parameters.items() if value},
        )


def parts(file: h5py.File, path: PathLike) -> List[str]:
    """The names of the root's groups that hold a mesh of schema S1."""
    return [
        name
        for name in children(path, file)
        if is_group_of_this_file(file, name) and is_group_of_this_file(file[name], schema.CHANNELS)
    ]
