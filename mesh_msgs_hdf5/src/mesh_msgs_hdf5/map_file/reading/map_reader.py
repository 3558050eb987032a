"""Reads one part of an open map file, one object at a time, in whatever layout it has."""
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from functools import partial
from typing import Any, Dict, Iterable, List, Optional, Sequence, Set, Tuple

import h5py

from mesh_msgs_hdf5.checks.check import checked_crs, checked_origin, from_json
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import attribute, row_attribute, text_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import (
    address,
    child,
    children,
    is_group_of_this_file,
    reached,
)
from mesh_msgs_hdf5.map_file.hdf5.hdf5_storage import declared_bytes
from mesh_msgs_hdf5.map_file.reading.feature_reader import FeatureReader
from mesh_msgs_hdf5.map_file.reading.geometry_reader import GeometryReader
from mesh_msgs_hdf5.map_file.reading.label_reader import LabelReader
from mesh_msgs_hdf5.map_file.reading.layouts import ROOT, default_part, find_parts, layout_of
from mesh_msgs_hdf5.map_file.reading.material_reader import MaterialReader
from mesh_msgs_hdf5.map_file.reading.named_arrays import NamedArrayReader
from mesh_msgs_hdf5.map_file.reading.seam_reader import SeamReader
from mesh_msgs_hdf5.map_file.reading.texture_reader import TextureReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh, geometry_uuid

# members of Mesh that are dictionaries: what gives their keys, and a value
_NAMED = {
    "vertex_costs": ("layer_names", "vertex_costs"),
    "layer_parameters": ("layer_names", "layer_parameters"),
    "face_attributes": ("face_attribute_names", "face_attribute"),
    "face_parameters": ("face_attribute_names", "face_parameters"),
    "vertex_attributes": ("vertex_attribute_names", "vertex_attribute"),
    "vertex_parameters": ("vertex_attribute_names", "vertex_parameters"),
    "textures": ("texture_indices", "texture"),
}
_THREAD_BYTES = 1 << 16  # of vertices, for whose hash a thread is started
_PLACE = ("frame_id", "origin", "crs")  # without which vertices mean nothing
_MEMBERS = tuple(f.name for f in fields(Mesh) if f.name not in ("vertices", "faces") + _PLACE)


class MapReader(
    GeometryReader,
    NamedArrayReader,
    TextureReader,
    MaterialReader,
    LabelReader,
    FeatureReader,
    SeamReader,
):
    """One part of an open h5py.File. Opening reads names, shapes and attributes, no arrays.

    Most of its members are those of MapFile, too; this one reads the file as it is open. A member
    raises MapFileError (with the given path) where nothing of it can be read: see PartReader.

    Attributes: file, path, part, layout, group (of the part).
    """

    def __init__(
        self, file: h5py.File, path: PathLike, part: Optional[str] = None, strict: bool = False
    ) -> None:
        self.path = path
        self.file = file
        components = schema.part_path(path, default_part(file, path) if part is None else part)
        self.part = "/".join(components)
        group: Optional[h5py.Group] = file["/"]
        for name in components:
            group = child(path, group, name) if group is not None else None
        layout = None if group is None else layout_of(group, components)[0]
        if layout is None:
            raise self._no_mesh()
        self.group = group
        super().__init__(GuardedGroup(path, group), layout, strict)

    def _no_mesh(self):
        known = [part or "/" for part in self.parts]
        return MapFileError(
            "part" if known else "no_mesh",
            self.path,
            "there is no mesh in /%s" % self.part,
            (
                "parts of this file: %s" % ", ".join(known)
                if known
                else "is it a mesh map? one of ours has /mesh/channels/vertices"
            ),
        )

    def _absolute(self, place):
        return "/".join(("", self.part, place)) if self.part != ROOT else "/" + place

    @property
    def parts(self) -> List[str]:
        """The names of all parts of the file; "" is the root group."""
        return find_parts(self.file, self.path)

    @property
    def schema(self) -> str:
        return self.layout.schema

    @property
    def schema_version(self) -> int:
        if self.schema != "S1":
            return 0
        value = attribute(self.path, self.group, schema.SCHEMA_VERSION)
        if value is not None and (not isinstance(value, int) or value < 0):
            raise MapFileError("value", self.path, "%s is %r" % (schema.SCHEMA_VERSION, value), "")
        return value or 0

    def text(self, name: str, default: Optional[str] = None) -> Optional[str]:
        """An attribute of the part's group, refused if it is not a text."""
        value = text_attribute(self.path, self.group, name)
        return default if value is None else value

    @property
    def frame_id(self) -> str:
        """The coordinate frame; "map" for a file that does not say."""
        frame_id = self.text(schema.FRAME_ID, "map")
        schema.check_frame_id(self.path, frame_id)
        return frame_id

    @property
    def origin(self) -> Tuple[float, float, float]:
        """(x, y, z) in meters; vertices + origin are coordinates in crs. Zeros if not said."""
        origin = row_attribute(self.path, self.group, schema.ORIGIN, 3)
        return (0.0, 0.0, 0.0) if origin is None else checked_origin(self.path, origin)

    @property
    def crs(self) -> str:
        """The coordinate reference system of origin; "" if not said."""
        return self.tolerated(lambda: checked_crs(self.path, self.text(schema.CRS, "")), "")

    @property
    def source(self) -> Dict[str, Any]:
        """Provenance (dict); {} for a file that does not say."""

        def read():
            return from_json(self.path, "attribute " + schema.SOURCE, self.text(schema.SOURCE))

        return self.tolerated(read, {})

    @property
    def stored_uuid(self) -> Optional[str]:
        """The UUID in the file; None if it has none."""
        return self.text(schema.UUID) or None

    # all of it

    def read(self, members: Optional[Iterable[str]] = None) -> Mesh:
        """Everything, read at one moment; in a file of ours the geometry must be its UUID's.

        What cannot be read is left out, with a note, but for the geometry and where it is.
        members: names of members of Mesh; only these, the geometry and where it is are read.
        """
        if members is None:
            self.guarded.check_total(sum(map(self._declared_bytes, self._places())))
        mesh = Mesh(vertices=self.vertices, faces=self.faces)
        stored = self.stored_uuid if self.schema_version else None
        with ThreadPoolExecutor(1) as pool:  # the hash takes a third of the time of reading
            uuid = partial(geometry_uuid, mesh.vertices, mesh.faces)
            if stored and mesh.vertices.nbytes > _THREAD_BYTES:
                uuid = pool.submit(uuid).result
            self._read_attributes(mesh, members)
        if stored and stored != uuid():
            raise MapFileError(
                "uuid",
                self.path,
                "vertices and faces are not those of UUID %s: the file was damaged, or another "
                "program changed them" % stored,
                "restore the file, or import the mesh again",
            )
        return mesh

    def _declared_bytes(self, place):
        """Of a dataset; 0 if it cannot be read."""
        try:
            return declared_bytes(self.guarded.dataset(place, fields=True))
        except MapFileError as error:
            if error.code == "size" or place in (self.layout.vertices, self.layout.faces):
                raise
            return 0  # whoever reads it says why

    def _read_attributes(self, mesh, members):
        for name in _PLACE + (_MEMBERS if members is None else tuple(members)):
            if name not in _PLACE + _MEMBERS:
                raise MapFileError("value", self.path, "a mesh has no member %r" % name, "")
            if name == "seam_originals":  # of the geometry that has just been read
                mesh.seam_originals = self.originals_of(mesh.vertices, mesh.faces)
                continue
            value = getattr(self, _NAMED[name][0] if name in _NAMED else name)
            if name in _NAMED:
                value = self._all_of(value(), getattr(self, _NAMED[name][1]))
            elif name == "labels":
                value = value()
            if name.endswith("_parameters"):
                value = {key: parameters for key, parameters in value.items() if parameters}
            setattr(mesh, name, value)
        if mesh.materials is not None and (members is None or "textures" in members):
            self.without_textures(mesh.materials, mesh.textures)

    def _all_of(self, keys, read):
        """What can be read, by its key."""
        found = {}
        for key in keys:
            value = self.tolerated(lambda: read(key), None)
            if value is not None:
                found[key] = value
        return found

    def own_paths(self) -> Set[str]:
        """The absolute paths of all datasets of the Mesh, and of groups that say nothing.

        All else in the file is unknown to us, and is to survive.
        """
        own = {self._absolute(place) for place in self._places()}
        own.update(self.feature_paths().values())
        labels = self.layout.labels
        for place in self.label_paths().values():
            own.add(self._absolute("/".join((labels,) + place)))
        groups = list(self.layout.structure)
        if labels:
            names = self.tolerated(lambda: self.guarded.names(labels), [])
            groups += ["%s/%s" % (labels, name) for name in names]
        own.update(self._absolute(place) for place in groups if self.guarded.is_empty(place))
        return own | self._further_names()

    def _further_names(self):
        """Of normals and colors, for which S2 has two places, and which may be stored once."""
        found = set()
        for places in (self.layout.normals, self.layout.colors):
            objects = {path: reached(self.file, path) for path in map(self._absolute, places)}
            there = {path: address(what) for path, what in objects.items() if what is not None}
            found.update(path for path in there if there[path] == next(iter(there.values())))
        return found

    def _places(self):
        """Where all of the Mesh is but labels and features, of which there may be very many."""
        places = self.geometry_places()
        places += self.layer_places.values()
        places += self.vertex_attribute_places.values()
        places += self.face_attribute_places.values()
        return places + self.texture_places() + self.material_places() + self.seam_places()

    def other_contents(self, within: Sequence[str] = ()) -> List[str]:
        """Paths of what is in the file but neither in this Mesh nor another part.

        within: paths of groups of which, if all in them is such, not the group is named, but what
        is in it: another layout knows of it, and names that.
        """
        structure = {self._absolute(place) for place in self.layout.structure}.union(within)
        others = [part for part in self.parts if part and part != self.part]
        return other_contents(self.file, self.path, self.own_paths(), structure, others)


def other_contents(
    file: h5py.File, path: PathLike, own: Set[str], structure: Set[str], others: Iterable[str]
) -> List[str]:
    """The absolute paths of what is neither in own (see MapReader.own_paths) nor in another part.

    structure: absolute paths of groups that say nothing by themselves. others: names of the other
    parts. Of any other group in which nothing is ours the group is named, not what is in it; links
    are not followed. In the order of a walk through the file.
    """
    known = own.union("/" + part for part in others)
    ways = set(structure)
    for place in known | structure:
        while "/" in place[1:]:
            place = place.rpartition("/")[0]
            ways.add(place)
    found: List[str] = []
    _walk(path, file["/"], "", known, ways, found)
    return found


def _walk(path, group, prefix, known, ways, found):
    """No deeper than what is known, so that nothing can make it go deep."""
    undecoded: List[str] = []
    for name in children(path, group, tell=undecoded.append):
        place = "%s/%s" % (prefix, name)
        if place in known:
            continue
        if place in ways and is_group_of_this_file(group, name):
            _walk(path, group[name], place, known, ways, found)
        else:
            found.append(place)
    found += [prefix + "/(name that is not UTF-8)"] * bool(undecoded)
