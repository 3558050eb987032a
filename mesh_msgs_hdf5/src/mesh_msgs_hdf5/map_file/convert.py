"""Rewrites map files: from any schema to S1, for LVR2 and ROS 2, and without unused space."""
import os
import types
from typing import List, Mapping, Optional, Set

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import checked_mesh
from mesh_msgs_hdf5.files.save import check_target, stamp
from mesh_msgs_hdf5.map_file.hdf5 import chunks
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import reached
from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.map_file.writing.check_edit import checked_edit
from mesh_msgs_hdf5.map_file.writing.edit_writer import apply_edit
from mesh_msgs_hdf5.map_file.writing.hdf5_stream import Stream, building, reading_stream
from mesh_msgs_hdf5.map_file.writing.map_saving import bytes_of, part_group, save_built, verify
from mesh_msgs_hdf5.map_file.writing.lvr2_part import write_lvr2_part
from mesh_msgs_hdf5.map_file.writing.object_writer import (
    SMALL_BYTES,
    ObjectWriter,
    check_compression,
    free,
)
from mesh_msgs_hdf5.map_file.writing.part_names import PartNames
from mesh_msgs_hdf5.map_file.writing.part_writer import PartWriter
from mesh_msgs_hdf5.map_file.writing.raw_compare import RawComparison
from mesh_msgs_hdf5.map_file.writing.raw_copy import copy_attributes, copy_everything
from mesh_msgs_hdf5.map_file.writing.references import carry_references
from mesh_msgs_hdf5.map_file.writing.ros2_part_writer import (
    Ros2PartWriter,
    remove_vertex_attributes,
)
from mesh_msgs_hdf5.map_file.writing.texture_writer import IMAGE_ATTRIBUTES
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.edit import Edit, LabelChanges, changed_labels
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import TEXT
from mesh_msgs_hdf5.model.mending import mended_normals

_NONE: Mapping[str, LabelChanges] = types.MappingProxyType({})
PROFILES = ("s1", "lvr2", "both", "ros2")
_NOT_IMAGES = "not textures"  # a group of the part, for what LVR2 would take for a texture
_KNOWN_ATTRIBUTES = frozenset(IMAGE_ATTRIBUTES) | {
    schema.KIND,
    schema.PARAMETERS,
    schema.LABEL_COLOR,
    schema.FEATURE_LOCATION,
    schema.PARENT_UUID,
    TEXT,
}


def convert(
    source_path: PathLike,
    target_path: PathLike,
    part: Optional[str] = None,
    profile: str = "s1",
    overwrite: bool = False,
    label_changes: Mapping[str, LabelChanges] = _NONE,
) -> List[str]:
    """Write a part of a map file of any schema as schema S1 or S2; returns notes on what changed.

    part: as in MapFile. profile: "s1"; "lvr2" with textures and materials as LVR2 had them until
    2024-11, so that its MeshIO loads the file; "both": as s1, with a second part for LVR2 (see
    lvr2_part.py); "ros2": schema S2, for LVR2 since 2024-12 and the mesh tools of ROS 2, which is
    only read here. A part at the root becomes mesh, except in S1.
    Everything else in the file is carried over as it is stored, other parts included; what is in
    the way gets another name, which is noted. The source is not touched. label_changes: part ->
    changes of its labels, of parts that are carried over only where they are of S1. Raises
    MapFileError.
    """
    if profile not in PROFILES:
        raise MapFileError(
            "value", target_path, "profile %r is not known" % (profile,), ", ".join(PROFILES)
        )
    check_target(target_path, overwrite)
    _check_not_the_same(source_path, target_path)
    return _rewrite(source_path, target_path, part, profile, overwrite, label_changes)


def repair(
    source_path: PathLike,
    target_path: PathLike,
    part: Optional[str] = None,
    overwrite: bool = False,
    label_changes: Mapping[str, LabelChanges] = _NONE,
) -> List[str]:
    """As convert() to schema S1; of a map of that schema, source and target may be the same file.

    What cannot be read is not in the new file, what can be mended is (see PartReader); a note says
    each. A file in which nothing is wrong is not written over itself. Raises MapFileError.
    """
    check_target(target_path, overwrite)
    expected = None
    if _is_same(source_path, target_path):
        expected = stamp(source_path)
        with reading(source_path) as source:
            reader = MapReader(source, source_path, part)
            if reader.schema != "S1":
                text = "it is a file of schema %s, which is only read" % reader.schema
                raise MapFileError("schema", source_path, text, "name another file for the result")
            reader.restores_seams = True
            reader.read()
            if not reader.notes:
                return []
    changes = label_changes, expected
    return _rewrite(source_path, target_path, part, "s1", overwrite, *changes, repairs=True)


def _rewrite(
    source_path,
    target_path,
    part,
    profile,
    overwrite,
    label_changes,
    expected=None,
    repairs=False,
):
    notes: List[str] = []
    with reading(source_path) as source:
        reader = MapReader(source, source_path, part)
        reader.restores_seams = repairs
        _check_version(reader)
        mesh = reader.read()
        if reader.part in label_changes:
            mesh.labels = changed_labels(mesh.labels, label_changes[reader.part])
            mesh = checked_mesh(target_path, mesh)
        others = {part: found for part, found in label_changes.items() if part != reader.part}
        names = PartNames.of_mesh(mesh)
        own = reader.own_paths()
        notes += reader.notes
        target_part = _target_part(reader, notes)
        if profile == "ros2":
            _make_fit_for_map3d(mesh, target_part, notes)
            names = PartNames.of_mesh(mesh)
        _note_what_is_lost(source, reader, own, mesh.uuid, notes)

        def build(stream: Stream) -> None:
            writer = ObjectWriter(target_path, notes=notes)
            with building(stream, target_path, source) as file:
                copy_everything(source_path, source, file)
                writer.remove_all(file, own)
                if reader.schema == "S2":
                    remove_vertex_attributes(writer, file.get("/" + reader.part))
                group = part_group(writer, file, target_part)
                if profile in ("lvr2", "ros2"):
                    _clear_textures(writer, group)
                if profile == "ros2":
                    writer.remove_attribute(group, schema.SCHEMA_VERSION)
                    Ros2PartWriter(writer, group).mesh(mesh)
                else:
                    PartWriter(writer, group, lvr2=profile == "lvr2").mesh(mesh)
                if profile == "both":
                    write_lvr2_part(writer, file, target_part, mesh)
                _change_labels(writer, source, file, others)
                carry_references(source, file, writer.moved, target_path)
            verify(target_path, stream, writer, target_part, names, source)

        room = source.id.get_filesize() + bytes_of(mesh) + bytes_of(dict(label_changes))
        save_built(target_path, build, room, expected=expected, overwrite=overwrite, compact=True)
    return notes


def repack(
    source_path: PathLike,
    target_path: PathLike,
    compression: str = "gzip",
    overwrite: bool = False,
    label_changes: Mapping[str, LabelChanges] = _NONE,
) -> None:
    """Write a map file anew, without unused space, and with the arrays of its meshes compressed
    ("gzip") or contiguous ("none").

    All else is carried over as it is stored. With overwrite, source and target may be the same
    file. label_changes: part -> changes of its labels, where it is of S1. Raises MapFileError.
    """
    check_compression(target_path, compression)
    check_target(target_path, overwrite)
    expected = stamp(source_path) if _is_same(source_path, target_path) else None
    with reading(source_path) as source:
        own: Set[str] = set()
        for part in MapReader(source, source_path).parts:
            own |= MapReader(source, source_path, part).own_paths()
        own = {place for place in own if _is_worth_recoding(reached(source, place))}

        def build(stream: Stream) -> None:
            writer = ObjectWriter(target_path, compression)
            with building(stream, target_path, source) as file:
                copy_everything(source_path, source, file)
                for place in sorted(own):
                    _recode(target_path, file[place], compression)
                _change_labels(writer, source, file, label_changes)
                carry_references(source, file, writer.moved, target_path)
            with reading_stream(stream, target_path) as file:
                writer.check_written(file)
                written = writer.removed, writer.created, writer.moved, writer.changed
                RawComparison(target_path, *written, recoded=own).check(source, file)

        room = source.id.get_filesize() + 2 * _stored_bytes(source, own)
        room += bytes_of(dict(label_changes))
        save_built(target_path, build, room, expected=expected, overwrite=overwrite, compact=True)


def _change_labels(writer, source, file, label_changes):
    """Change labels of parts that are carried over."""
    for part, changes in label_changes.items():
        reader = MapReader(source, writer.path, part)
        if changes and reader.schema == "S1" and reader.schema_version <= schema.VERSION:
            edit = checked_edit(Edit(labels=dict(changes)), reader)
            apply_edit(writer, file["/" + part], reader, edit)


def _is_same(source_path, target_path):
    return os.path.exists(target_path) and os.path.samefile(source_path, target_path)


def _check_not_the_same(source_path, target_path):
    if _is_same(source_path, target_path):
        raise MapFileError(
            "exists", target_path, "it is the file that is to be converted", "name another one"
        )


def _check_version(reader):
    if reader.schema_version > schema.VERSION:
        raise MapFileError(
            "version",
            reader.path,
            "it was written by a newer Mesh Tools (schema %d)" % reader.schema_version,
            "use that one",
        )


def _target_part(reader, notes):
    """The part's name in S1; one that no other part has."""
    part = reader.part
    if reader.schema == "S1":
        return part
    if reader.layout.below:
        part = part[len(reader.layout.below) + 1 :]
    wanted = part = part or "mesh"
    number = 1
    while part != reader.part and part in reader.parts:
        number += 1
        part = "%s (%d)" % (wanted, number)
    if part != reader.part:
        notes.append("the part /%s is now /%s" % (reader.part, part))
    return part


def _note_what_is_lost(source, reader, own, uuid, notes):
    lost = []
    for place in sorted(own):
        found = reached(source, place)  # None: a link, which was not read
        names = set() if found is None else set(found.attrs) - _KNOWN_ATTRIBUTES
        lost += ["%s of %s" % (name, place) for name in sorted(names)]
    if lost:
        notes.append("left out: %d attributes of arrays, first %s" % (len(lost), lost[0]))
    stored = reader.stored_uuid
    if stored and stored != uuid:
        notes.append("the UUID %s is now that of the geometry, %s" % (stored, uuid))


def _make_fit_for_map3d(mesh, part, notes):
    """RViz's Map3D of ROS 2 ends where a mesh has nothing at its vertices."""
    if mesh.vertex_normals is None and mesh.vertex_colors is None and not mesh.vertex_costs:
        count = len(mesh.vertices)
        none, all_of_them = np.zeros((count, 3), np.float32), np.ones(count, bool)
        mesh.vertex_normals = mended_normals(none, all_of_them, mesh.vertices, mesh.faces)
        notes.append("normals were added: RViz's Map3D of ROS 2 shows no mesh without")
    if part != "mesh":
        text = "RViz's Map3D of ROS 2 shows the part mesh alone, and this one is %s"
        notes.append(text % (part or "the root"))


def _clear_textures(writer, part):
    """LVR2 reads every child of textures as an image, whatever it is."""
    textures = part.get(schema.TEXTURES)
    if isinstance(textures, h5py.Group) and len(textures):
        others = writer.group(part, free(part, _NOT_IMAGES))
        for name in list(textures):
            new = writer.move(textures, name, others, name)
            writer.note("%s/%s was moved to %s, for LVR2's sake", textures.name, name, new)


def _is_worth_recoding(found):
    if not isinstance(found, h5py.Dataset):
        return False
    if h5py.h5o.get_info(found.id).rc > 1:
        return False  # its other names would still lead to the old one
    return found.size * found.dtype.itemsize >= SMALL_BYTES


def _recode(path, found, compression):
    """Store a dataset anew, with its attributes."""
    parent, name = found.parent, found.name.rpartition("/")[2]
    writer = ObjectWriter(path, compression)
    new_name = free(parent, name)
    copy_attributes(found, writer.array(parent, new_name, chunks.load(found)))
    parent.id.unlink(name.encode("utf-8"))
    parent.id.links.move(new_name.encode("utf-8"), parent.id, name.encode("utf-8"))


def _stored_bytes(source, places):
    """The bytes of arrays when they are not compressed."""
    found = (source[place] for place in places)
    return sum(d.size * d.dtype.itemsize for d in found if isinstance(d, h5py.Dataset))
