"""The map file: one mesh with everything that is known about it, in one HDF5 file of schema S1."""
import contextlib
import os
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5 import schema
from mesh_msgs_hdf5.check import checked_costs, checked_mesh
from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.hdf5_files import reading
from mesh_msgs_hdf5.hdf5_guard import children, is_group_of_this_file, join
from mesh_msgs_hdf5.hdf5_image import image_with_layers, mesh_image
from mesh_msgs_hdf5.map_reader import MapReader, parts
from mesh_msgs_hdf5.mesh import Mesh, geometry_uuid
from mesh_msgs_hdf5.probe import check_name
from mesh_msgs_hdf5.save import check_target, save_file, stamp

_KNOWN_CHANNELS = frozenset(schema.ARRAYS)


class MapFile:
    """One part of a map file.

    Opening reads names and shapes; each array is read when it is asked for, and not kept.

    The file is open only during a call. If its geometry is replaced meanwhile, the next call is
    refused (code changed), so that arrays of two meshes never mix. Every method raises MapFileError
    and nothing else for a file that is not sound; nothing outside the file is ever read.

    Attributes: path, part, vertex_count, face_count, schema_version (0: the file does not say),
    parts (names of all parts), has_normals, has_colors.
    """

    def __init__(self, path: PathLike, part: str = "mesh") -> None:
        check_name(path)
        self.path = os.fsdecode(path)
        self.part = part
        self._stamp = None
        with self._reader():
            pass

    @contextlib.contextmanager
    def _reader(self):
        """A MapReader on the file as it is now."""
        now = stamp(self.path)
        with reading(self.path) as file:
            reader = MapReader(file, self.path, self.part)
            if now != self._stamp:
                self._take_header(file, reader, now)
            yield reader

    def _take_header(self, file, reader, now):
        identity = (reader.vertex_count, reader.face_count, reader.text(schema.UUID))
        if self._stamp is not None and (identity != self._identity or identity[2] is None):
            raise MapFileError(
                "changed", self.path, "another program has replaced the mesh", "open it again"
            )
        self._identity = identity
        self._stamp = now
        self.vertex_count, self.face_count = identity[:2]
        self.schema_version = reader.schema_version()
        self.has_normals = reader.has(schema.NORMALS)
        self.has_colors = reader.has(schema.COLORS)
        self.parts = parts(file, self.path)

    @property
    def vertices(self) -> np.ndarray:
        """(V, 3) float32, meters in frame_id; finite."""
        with self._reader() as reader:
            return reader.array(schema.VERTICES)

    @property
    def faces(self) -> np.ndarray:
        """(F, 3) uint32, each below V."""
        with self._reader() as reader:
            return reader.array(schema.FACES)

    @property
    def vertex_normals(self) -> Optional[np.ndarray]:
        """(V, 3) float32, finite; None if the file has none."""
        with self._reader() as reader:
            return reader.array(schema.NORMALS)

    @property
    def vertex_colors(self) -> Optional[np.ndarray]:
        """(V, 3) uint8 red, green, blue; None if the file has none."""
        with self._reader() as reader:
            return reader.array(schema.COLORS)

    def layer_names(self) -> List[str]:
        """The names of the vertex cost layers, sorted."""
        with self._reader() as reader:
            return reader.layer_names()

    def vertex_costs(self, name: str) -> np.ndarray:
        """(V,) float32 of one layer: finite >= 0 is a cost, +inf lethal, NaN unknown."""
        with self._reader() as reader:
            return reader.layer(name)

    def layer_parameters(self, name: str) -> Dict[str, Any]:
        """The parameters that a layer was computed with (dict); {} if the file does not say."""
        with self._reader() as reader:
            return reader.layer_parameters(name)

    @property
    def frame_id(self) -> str:
        """The coordinate frame; "map" for a file that does not say."""
        with self._reader() as reader:
            return reader.frame_id()

    @property
    def source(self) -> Dict[str, Any]:
        """Provenance (dict); {} for a file that does not say."""
        with self._reader() as reader:
            return reader.source()

    @property
    def uuid(self) -> str:
        """The UUID in the file; if it has none, that of its geometry (which is then read)."""
        with self._reader() as reader:
            stored = reader.text(schema.UUID)
            if stored:
                return stored
            return geometry_uuid(reader.array(schema.VERTICES), reader.array(schema.FACES))

    def read(self) -> Mesh:
        """Everything, read at one moment; in a file of ours the geometry must be its UUID's."""
        with self._reader() as reader:
            mesh = reader.mesh()
            stored = reader.text(schema.UUID)
            if self.schema_version and stored and stored != mesh.uuid:
                raise MapFileError(
                    "uuid",
                    self.path,
                    "vertices and faces are not those of UUID %s: the file was damaged, or another "
                    "program changed them" % stored,
                    "restore the file, or import the mesh again",
                )
            return mesh

    def other_contents(self) -> List[str]:
        """Paths of what is in the file but not in a Mesh: labels, textures, other groups."""
        found = []
        with self._reader() as reader:
            group = reader.group
            own = _KNOWN_CHANNELS | set(reader.layer_names())
            for name in children(self.path, group):
                if name not in schema.GROUPS or not is_group_of_this_file(group, name):
                    found.append(join(group, name))
                    continue
                below = children(self.path, group[name])
                if name == schema.CHANNELS:
                    below = [channel for channel in below if channel not in own]
                found += [join(group[name], inner) for inner in below]
            top = group.file["/"]
            known = set(self.parts) | set(schema.part_path(self.path, self.part)[:1])
            if group.name != "/":
                found += ["/" + name for name in children(self.path, top) if name not in known]
        return found

    def write_layers(self, layers: Dict[str, Tuple[np.ndarray, Optional[dict]]]) -> None:
        """Add or replace layers: {name: (costs (V,) float, parameters dict or None)}.

        The file is rewritten in one step (see save.py); everything else in it stays as it is.
        Raises MapFileError; then the old file is untouched.
        """
        check_target(self.path, overwrite=True)
        checked = {}
        for name, (costs, parameters) in layers.items():
            schema.check_layer_name(self.path, name)
            checked[name] = (
                checked_costs(self.path, name, costs, self.vertex_count),
                parameters,
            )
        now = stamp(self.path)
        with self._reader() as reader:
            if self.schema_version > schema.VERSION:
                raise MapFileError(
                    "version",
                    self.path,
                    "it was written by a newer Mesh Tools (schema %d)" % self.schema_version,
                    "use that one, or save the layers to another file",
                )
            image = image_with_layers(self.path, reader.group.file, self.part, checked)
        save_file(self.path, image, expected=now)

    @classmethod
    def write(
        cls, path: PathLike, mesh: Mesh, part: str = "mesh", overwrite: bool = True
    ) -> "MapFile":
        """Save a Mesh as a new map file with this one part; returns its MapFile.

        It takes the place of a file that is there in one step (see save.py).

        Raises MapFileError; then a file that was there before is untouched.
        """
        check_target(path, overwrite)
        image = mesh_image(path, checked_mesh(path, mesh), part)
        save_file(path, image, overwrite=overwrite)
        return cls(path, part)
