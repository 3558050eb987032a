"""The map file: one mesh with everything that is known about it, in one HDF5 file."""
import contextlib
import functools
import inspect
import os
from typing import Any, Dict, Iterator, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.files.probe import check_name
from mesh_msgs_hdf5.files.save import check_target, stamp
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.part_changes import copy_part, delete_parts, put_part, rename_part
from mesh_msgs_hdf5.map_file.reading.layouts import find_parts
from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.map_file.writing.map_saving import save_edit, save_mesh
from mesh_msgs_hdf5.model.edit import Edit, is_empty
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Label, Mesh, geometry_uuid

# of MapReader, which a MapFile has, too
MEMBERS = (
    *("vertices", "vertex_rounding", "faces"),
    *("vertex_normals", "vertex_colors", "texture_coordinates"),
    *("layer_names", "vertex_costs", "layer_parameters", "all_layer_parameters"),
    *("vertex_attribute_names", "vertex_attribute", "vertex_parameters"),
    *("face_attribute_names", "face_attribute", "face_parameters"),
    *("texture_indices", "texture", "textures_form", "materials", "features"),
    *("has_seams", "seam_originals", "parent_uuid"),
    *("label_names", "label", "labels"),
    *("frame_id", "origin", "crs", "source", "stored_uuid"),
    *("parts", "other_contents", "read"),
)


class MapFile:
    """One part of a map file, in any of the layouts of layouts.py.

    Opening reads names and shapes; each array is read when it is asked for, and not kept.

    The file is open only during a call. If its geometry is replaced meanwhile, the next call is
    refused (code changed), so that arrays of two meshes never mix; where the file has no UUID, so
    is any change by others, unless uuid was asked for before. Every member raises MapFileError and
    nothing else for a file that is not sound; nothing outside the file is ever read.

    One bad value does not make a map useless. Only the geometry, its frame and origin must be good.
    Of all else, what is bad is left out or mended (a value -inf of a layer is NaN; PartReader), as
    if the file did not have it, and notes says so. What is asked for by a name and cannot be read
    is an error.

    part: its name; "" or "/" is the root group; None stands for mesh if there is one, else for the
    only one (code part if there are several). strict: what is bad is an error, whatever it is.

    Attributes: path, part, strict, notes (what was left out or mended in what was read so far of
    the file as it is now, a sentence for each), schema ("S0", "S1", "S2", "meshes"), schema_version
    (0: the file does not say), vertex_count, face_count, has_normals, has_colors. Its other members
    are those of MapReader that have the names in MEMBERS: each opens the file once.
    """

    def __init__(self, path: PathLike, part: Optional[str] = None, strict: bool = False) -> None:
        check_name(path)
        self.strict = strict
        self.notes: List[str] = []
        self.path = os.fsdecode(path)
        self.part = part
        self._stamp = self._saved = None  # the file when it was looked at, and saved, last
        self._computed_uuid: Optional[str] = None
        with self._reader():
            pass

    def __enter__(self) -> "MapFile":
        return self

    def __exit__(self, *_: Any) -> None:
        """As IsolatedMapFile, which has something to close."""

    @contextlib.contextmanager
    def _reader(self) -> Iterator[MapReader]:
        """A MapReader on the file as it is now."""
        now = stamp(self.path)
        with reading(self.path) as file:
            reader = MapReader(file, self.path, self.part, self.strict)
            if now != self._stamp:
                self._take_header(reader, now)
            try:
                yield reader
            finally:
                self.notes = list(dict.fromkeys(self.notes + reader.notes))

    def _take_header(self, reader, now):
        identity = (reader.vertex_count, reader.face_count, reader.stored_uuid)
        if self._stamp is not None and (
            identity != self._identity
            or identity[2] is None  # of the same size, but is it the same mesh?
            and not (now == self._saved or self._is_computed_uuid(reader))
        ):
            raise MapFileError(
                "changed", self.path, "another program has replaced the mesh", "open it again"
            )
        self.part = reader.part
        self.schema = reader.schema
        self.schema_version = reader.schema_version
        self.vertex_count, self.face_count = identity[:2]
        self.has_normals = reader.has_normals
        self.has_colors = reader.has_colors
        self._identity = identity
        self._stamp = now
        self.notes = []

    def _is_computed_uuid(self, reader):
        known = self._computed_uuid
        return known is not None and known == geometry_uuid(reader.vertices, reader.faces)

    @property
    def uuid(self) -> str:
        """The UUID in the file; if it has none, that of its geometry (which is then read)."""
        with self._reader() as reader:
            uuid = reader.stored_uuid
            if not uuid:
                uuid = self._computed_uuid = geometry_uuid(reader.vertices, reader.faces)
            return uuid

    def update(self, edit: Edit) -> None:
        """Add, replace and remove what an Edit says.

        The file is rewritten in one step (see save.py); everything else in it stays as it is
        stored. What is replaced loses its attributes; to remove what is not there is no error; an
        Edit that says nothing changes nothing. Raises MapFileError (schema: only files of S1 are
        edited; version: a newer one is not; changed: another program saved it meanwhile; and those
        of the values); then the old file is untouched.
        """
        check_target(self.path, overwrite=True)
        if is_empty(edit):
            return
        now = stamp(self.path)
        with self._reader() as reader:
            names = save_edit(reader, edit, now)
        self._saved = stamp(self.path)
        self.has_normals, self.has_colors = names.normals, names.colors

    def write_layers(self, layers: Dict[str, Tuple[np.ndarray, Optional[Dict[str, Any]]]]) -> None:
        """Add or replace layers: {name: (costs (V,) float, parameters dict or None)}; as update."""
        self.update(
            Edit(
                vertex_costs={name: costs for name, (costs, _) in layers.items()},
                layer_parameters={name: parameters for name, (_, parameters) in layers.items()},
            )
        )

    @classmethod
    def write(
        cls,
        path: PathLike,
        mesh: Mesh,
        part: str = "mesh",
        overwrite: bool = True,
        compression: str = "gzip",
    ) -> "MapFile":
        """Save a Mesh as a new map file with this one part; returns its MapFile.

        It takes the place of a file that is there in one step (see save.py). compression: "gzip",
        or "none" for a local map that is read often.

        Raises MapFileError; then a file that was there before is untouched.
        """
        check_target(path, overwrite)
        save_mesh(path, mesh, part, overwrite, compression)
        return cls(path, part)

    @classmethod
    def write_part(
        cls,
        path: PathLike,
        mesh: Mesh,
        part: str,
        overwrite: bool = False,
        compression: str = "gzip",
    ) -> "MapFile":
        """Save a Mesh as a part of a map file that is there; returns its MapFile. See put_part."""
        put_part(path, mesh, part, overwrite, compression)
        return cls(path, part)

    def rename_part(self, new: str) -> None:
        """Give this part another name; see rename_part of part_changes."""
        rename_part(self.path, self.part, new)
        self.part = new

    def delete_part(self, last: bool = False) -> None:
        """Remove this part; see delete_parts. The object is of no use any more then."""
        delete_parts(self.path, [self.part], last)

    def copy_part(
        self,
        new: str,
        path: Optional[str] = None,
        label_changes: Optional[Dict[str, Optional[Label]]] = None,
    ) -> None:
        """Copy this part as the part new into this map file, or another one; see copy_part."""
        copy_part(self.path, self.part, path or self.path, new, label_changes or {})


def _forwarded(member):
    """A member of MapReader, of the file as it is at each call."""
    function = member.fget if isinstance(member, property) else member
    parameters = inspect.signature(function)

    @functools.wraps(function)
    def ask(self, *arguments, **keywords):
        parameters.bind(self, *arguments, **keywords)  # a wrong call is a TypeError
        with self._reader() as reader:
            return function(reader, *arguments, **keywords)

    return property(ask, doc=member.__doc__) if isinstance(member, property) else ask


for _name in MEMBERS:
    setattr(MapFile, _name, _forwarded(getattr(MapReader, _name)))


def parts_of(path: str) -> List[str]:
    """The names of all parts that hold a mesh; "" is the root group. Raises MapFileError."""
    with reading(path) as file:
        return find_parts(file, path)
