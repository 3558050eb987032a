"""The map file: one mesh with everything that is known about it, in one HDF5 file."""
import contextlib
import os
from typing import Any, Dict, Iterable, Iterator, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.files.probe import check_name
from mesh_msgs_hdf5.files.save import check_target, stamp
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.reading.layouts import find_parts
from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.map_file.writing.map_saving import save_edit, save_mesh
from mesh_msgs_hdf5.model.edit import Edit, is_empty
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh, geometry_uuid


class MapFile:
    """One part of a map file, in any of the layouts of layouts.py.

    Opening reads names and shapes; each array is read when it is asked for, and not kept.

    The file is open only during a call. If its geometry is replaced meanwhile, the next call is
    refused (code changed), so that arrays of two meshes never mix; where the file has no UUID, so
    is any change by others, unless uuid was asked for before. Every member raises MapFileError and
    nothing else for a file that is not sound; nothing outside the file is ever read.

    part: its name; "" or "/" is the root group; None stands for mesh if there is one, else for the
    only one (code part if there are several).

    Attributes: path, part, parts (names of all parts), schema ("S0", "S1", "S2", "meshes"),
    schema_version (0: the file does not say), vertex_count, face_count, has_normals, has_colors.
    """

    def __init__(self, path: PathLike, part: Optional[str] = None) -> None:
        check_name(path)
        self.path = os.fsdecode(path)
        self.part = part
        self._stamp = None
        self._computed_uuid: Optional[str] = None
        with self._reader():
            pass

    @contextlib.contextmanager
    def _reader(self, saved: bool = False) -> Iterator[MapReader]:
        """A MapReader on the file as it is now. saved: this object has just saved it."""
        now = stamp(self.path)
        with reading(self.path) as file:
            reader = MapReader(file, self.path, self.part)
            if now != self._stamp:
                self._take_header(reader, now, saved)
            yield reader

    def _take_header(self, reader, now, saved):
        identity = (reader.vertex_count, reader.face_count, reader.stored_uuid)
        if self._stamp is not None and (
            identity != self._identity
            or identity[2] is None  # of the same size, but is it the same mesh?
            and not (saved or self._is_computed_uuid(reader))
        ):
            raise MapFileError(
                "changed", self.path, "another program has replaced the mesh", "open it again"
            )
        self.part = reader.part
        self.parts = reader.parts
        self.schema = reader.schema
        self.schema_version = reader.schema_version
        self.vertex_count, self.face_count = identity[:2]
        self.has_normals = reader.has_normals
        self.has_colors = reader.has_colors
        self._identity = identity
        self._stamp = now

    def _is_computed_uuid(self, reader):
        known = self._computed_uuid
        return known is not None and known == geometry_uuid(reader.vertices, reader.faces)

    @property
    def vertices(self) -> np.ndarray:
        """(V, 3) float32, meters in frame_id; finite."""
        with self._reader() as reader:
            return reader.vertices

    @property
    def faces(self) -> np.ndarray:
        """(F, 3) uint32, each below V."""
        with self._reader() as reader:
            return reader.faces

    @property
    def vertex_normals(self) -> Optional[np.ndarray]:
        """(V, 3) float32, finite; None if the file has none."""
        with self._reader() as reader:
            return reader.vertex_normals

    @property
    def vertex_colors(self) -> Optional[np.ndarray]:
        """(V, 3) uint8 red, green, blue; None if the file has none."""
        with self._reader() as reader:
            return reader.vertex_colors

    def layer_names(self) -> List[str]:
        """The names of the vertex cost layers, sorted."""
        with self._reader() as reader:
            return reader.layer_names()

    def vertex_costs(self, name: str) -> np.ndarray:
        """(V,) float32 of one layer: finite >= 0 is a cost, +inf lethal, NaN unknown."""
        with self._reader() as reader:
            return reader.vertex_costs(name)

    def layer_parameters(self, name: str) -> Dict[str, Any]:
        """The parameters that a layer was computed with (dict); {} if the file does not say."""
        with self._reader() as reader:
            return reader.layer_parameters(name)

    def all_layer_parameters(self) -> Dict[str, Dict[str, Any]]:
        """Layer name -> its parameters, of all layers, sorted; no costs are read."""
        with self._reader() as reader:
            return reader.all_layer_parameters()

    def face_attribute_names(self) -> List[str]:
        """The names of the face attributes, sorted."""
        with self._reader() as reader:
            return reader.face_attribute_names()

    def face_attribute(self, name: str) -> np.ndarray:
        """(F,) or (F, C) numbers of one face attribute, in the type that they are stored in."""
        with self._reader() as reader:
            return reader.face_attribute(name)

    def face_parameters(self, name: str) -> Dict[str, Any]:
        """The parameters that a face attribute was computed with; {} if the file does not say."""
        with self._reader() as reader:
            return reader.face_parameters(name)

    @property
    def texture_coordinates(self) -> Optional[np.ndarray]:
        """(V, 2) float32 u, v; None if the file has none.

        The third value that hdf5_map_io stores is left out, and stays in the file.
        """
        with self._reader() as reader:
            return reader.texture_coordinates

    def texture_indices(self) -> List[int]:
        """The indices of the textures, ascending."""
        with self._reader() as reader:
            return reader.texture_indices()

    def texture(self, index: int) -> np.ndarray:
        """(height, width, 3) uint8, or (height, width, 4) with alpha; row 0 is the top."""
        with self._reader() as reader:
            return reader.texture(index)

    @property
    def materials(self) -> Optional[Materials]:
        """What the faces are made of; None if the file does not say it of each face."""
        with self._reader() as reader:
            return reader.materials

    def label_names(self) -> List[str]:
        """The texts of the labels, in natural order (tree_2 before tree_10)."""
        with self._reader() as reader:
            return reader.label_names()

    def label(self, text: str) -> Label:
        """One label; each face once, at its first place in the file."""
        with self._reader() as reader:
            return reader.label(text)

    def labels(self) -> Dict[str, Label]:
        """All labels by their texts, in natural order."""
        with self._reader() as reader:
            return reader.labels()

    @property
    def features(self) -> Optional[Features]:
        """The texture features; None if the file has none."""
        with self._reader() as reader:
            return reader.features

    @property
    def frame_id(self) -> str:
        """The coordinate frame; "map" for a file that does not say."""
        with self._reader() as reader:
            return reader.frame_id

    @property
    def origin(self) -> Tuple[float, float, float]:
        """(x, y, z) in meters; vertices + origin are coordinates in crs. Zeros if not said."""
        with self._reader() as reader:
            return reader.origin

    @property
    def crs(self) -> str:
        """The coordinate reference system of origin; "" if not said."""
        with self._reader() as reader:
            return reader.crs

    @property
    def source(self) -> Dict[str, Any]:
        """Provenance (dict); {} for a file that does not say."""
        with self._reader() as reader:
            return reader.source

    @property
    def uuid(self) -> str:
        """The UUID in the file; if it has none, that of its geometry (which is then read)."""
        with self._reader() as reader:
            uuid = reader.stored_uuid
            if not uuid:
                uuid = self._computed_uuid = geometry_uuid(reader.vertices, reader.faces)
            return uuid

    @property
    def stored_uuid(self) -> Optional[str]:
        """The UUID in the file; None if it has none."""
        with self._reader() as reader:
            return reader.stored_uuid

    def read(self, members: Optional[Iterable[str]] = None) -> Mesh:
        """Everything, read at one moment; in a file of ours the geometry must be its UUID's.

        members: names of members of Mesh; only these, the geometry and where it is are read.
        """
        with self._reader() as reader:
            return reader.read(members)

    def other_contents(self) -> List[str]:
        """Paths of what is in the file but neither in this Mesh nor another part."""
        with self._reader() as reader:
            return reader.other_contents()

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
            save_edit(reader, reader.group.file, edit, now)
        with self._reader(saved=True):  # takes the new header
            pass

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


def parts_of(path: str) -> List[str]:
    """The names of all parts that hold a mesh; "" is the root group. Raises MapFileError."""
    with reading(path) as file:
        return find_parts(file, path)
