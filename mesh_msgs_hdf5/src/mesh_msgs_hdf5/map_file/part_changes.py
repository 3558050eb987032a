"""Parts of a map file added, replaced, renamed, deleted and copied, each in one step.

All else in the file is carried over as it is stored, and compared with what was there.
"""
import contextlib
import os
import types
from typing import Iterable, List, Mapping, Optional

import h5py

from mesh_msgs_hdf5.checks.check import checked_mesh
from mesh_msgs_hdf5.files.save import Stamp, check_target, stamp
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import exists, is_group_of_this_file
from mesh_msgs_hdf5.map_file.reading.layouts import MAX_DEPTH, find_parts
from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.map_file.writing.check_edit import checked_edit
from mesh_msgs_hdf5.map_file.writing.edit_writer import apply_edit
from mesh_msgs_hdf5.map_file.writing.hdf5_stream import Stream, building, reading_stream
from mesh_msgs_hdf5.map_file.writing.map_saving import (
    bytes_of,
    check_editable,
    nothing_changed,
    part_group,
    save_built,
    verify,
)
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter, not_the_same
from mesh_msgs_hdf5.map_file.writing.part_names import PartNames
from mesh_msgs_hdf5.map_file.writing.part_writer import PartWriter
from mesh_msgs_hdf5.map_file.writing.raw_compare import RawComparison
from mesh_msgs_hdf5.map_file.writing.raw_copy import check_copyable, copy_everything
from mesh_msgs_hdf5.map_file.writing.references import carry_references
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Label, Mesh

_NONE: Mapping[str, Optional[Label]] = types.MappingProxyType({})


def put_part(
    path: PathLike, mesh: Mesh, part: str, overwrite: bool = False, compression: str = "gzip"
) -> List[str]:
    """Save a mesh as a part of a map file that is there, beside its others; returns notes.

    overwrite: it may replace the mesh of that part (of schema S1), of which what is not known to us
    stays, under another name if it is in the way. Raises MapFileError (exists; part: no good name).
    """
    expected = _expected(path)
    notes: List[str] = []
    with nothing_changed(path):
        mesh = checked_mesh(path, mesh)
    with reading(path) as source:
        parts = find_parts(source, path)
        is_new = "/".join(schema.part_path(path, part)) not in parts
        part = _part_name(path, part) if is_new else "/".join(schema.part_path(path, part))
        own: Iterable[str] = ()
        if part not in parts:
            _check_free(path, source, part, parts)
        elif not overwrite:
            raise _is_there(path, part, "use --force to replace it")
        else:
            reader = MapReader(source, path, part)
            check_editable(reader)
            own = reader.own_paths()

        def build(stream: Stream) -> None:
            writer = ObjectWriter(path, compression, notes)
            with building(stream, path, source) as file:
                copy_everything(path, source, file)
                writer.remove_all(file, own)
                PartWriter(writer, part_group(writer, file, part)).mesh(mesh)
                carry_references(source, file, writer.moved, path)
            verify(path, stream, writer, part, PartNames.of_mesh(mesh), source)
            _check_parts(path, stream, {*parts, part})

        room = source.id.get_filesize() + bytes_of(mesh)
        save_built(path, build, room, expected=expected, compact=bool(own))
    return notes


def rename_part(path: PathLike, part: str, new: str) -> None:
    """Give a part another name. Raises MapFileError (part: there is none, or no good new name)."""
    expected = _expected(path)
    with reading(path) as source:
        reader, parts = MapReader(source, path, part), find_parts(source, path)
        check_editable(reader)
        old, new = _group_of(reader), _part_name(path, new)
        _check_free(path, source, new, set(parts) - {old})
        names = PartNames.of_reader(reader)

        def build(stream: Stream) -> None:
            writer = ObjectWriter(path)
            with building(stream, path, source) as file:
                copy_everything(path, source, file)
                way, _, name = new.rpartition("/")
                to = part_group(writer, file, way)
                writer.remove(to, name)  # a group that says nothing, if there is any
                writer.move(*_parent(file, old), to, name)
                carry_references(source, file, writer.moved, path)
            verify(path, stream, writer, new, names, source)
            _check_parts(path, stream, {*parts, new} - {old})

        save_built(path, build, source.id.get_filesize(), expected=expected)


def delete_parts(path: PathLike, names: Iterable[str], last: bool = False) -> None:
    """Remove parts with all that is in their groups.

    last: there need be no mesh left then. Raises MapFileError (part: there is none of that name, or
    it is the last one).
    """
    expected = _expected(path)
    with reading(path) as source:
        readers = [MapReader(source, path, name) for name in names]
        for reader in readers:
            check_editable(reader)
        gone, parts = {_group_of(reader) for reader in readers}, set(find_parts(source, path))
        if not parts - gone and not last:
            raise MapFileError(
                "part",
                path,
                "no mesh would be left in it",
                "--force deletes the last one too; or remove the file",
            )

        def build(stream: Stream) -> None:
            writer = ObjectWriter(path)
            with building(stream, path, source) as file:
                copy_everything(path, source, file)
                for part in sorted(gone):
                    writer.remove(*_parent(file, part))
                    _remove_empty_groups(writer, file, part)
                carry_references(source, file, {}, path)
            with reading_stream(stream, path) as file:
                _compare(path, writer, source, file)
            _check_parts(path, stream, parts - gone)

        save_built(path, build, source.id.get_filesize(), expected=expected, compact=True)


def copy_part(
    source_path: PathLike,
    part: str,
    path: PathLike,
    new: str,
    label_changes: Mapping[str, Optional[Label]] = _NONE,
) -> None:
    """Copy a part of schema S1 as it is stored, with all that is in its group, into a map file
    (which may be the same) as the part new.

    label_changes: of the labels of the copy, as in an Edit. Raises MapFileError (exists, part).
    """
    expected = _expected(path)
    with contextlib.ExitStack() as opened:
        source = target = opened.enter_context(reading(source_path))
        if not os.path.samefile(source_path, path):
            check_copyable(source_path, source)
            target = opened.enter_context(reading(path))
        reader, parts = MapReader(source, source_path, part), find_parts(target, path)
        check_editable(reader)
        old, new = _group_of(reader), _part_name(path, new)
        _check_free(path, target, new, parts)
        edit = checked_edit(Edit(labels=dict(label_changes)), reader)
        names = PartNames.of_reader(reader).edited(edit)

        def build(stream: Stream) -> None:
            writer = ObjectWriter(path)
            with building(stream, path, target) as file:
                copy_everything(path, target, file)
                carry_references(target, file, {}, path)
                way, _, name = new.rpartition("/")
                parent = part_group(writer, file, way)
                writer.remove(parent, name)  # a group that says nothing, if there is any
                h5py.h5o.copy(reader.group.id, b".", parent.id, name.encode("utf-8"))
                writer.created.add("/" + new)
                moved, closed = {"/" + old: "/" + new}, source is not target
                carry_references(source, file, moved, path, "/" + old, closed)
                apply_edit(writer, parent[name], reader, edit)
            verify(path, stream, writer, new, names, target)
            with reading_stream(stream, path) as file:
                removed = {"/" + old + place[len(new) + 1 :] for place in writer.removed}
                comparison = RawComparison(path, removed, writer.created)
                comparison.check(source, file, "/" + old, "/" + new)
            _check_parts(path, stream, {*parts, new})

        room = target.id.get_filesize() + source.id.get_filesize() + bytes_of(edit)
        save_built(path, build, room, expected=expected)


def _expected(path) -> Optional[Stamp]:
    check_target(path, overwrite=True)
    return stamp(path)


def _part_name(path, part):
    """A new part's name; refuses those under which nobody would find it."""
    components = schema.new_part_path(path, part)
    if not 0 < len(components) <= MAX_DEPTH:
        text = "part name %r has %d components, it may have 1 to %d"
        text %= part[:80], len(components), MAX_DEPTH
        raise MapFileError("part", path, text, "choose another name")
    return "/".join(components)


def _group_of(reader):
    """The name of a part that has a group of its own."""
    if not reader.part:
        text = "the part / is the file itself, with all that is in it"
        raise MapFileError("part", reader.path, text, "mesh_tool export and import make a part")
    return reader.part


def _check_free(path, file, part, parts):
    """Refuse the name of a new part where something is already, but a group that says nothing."""
    if part in parts:
        raise _is_there(path, part, "delete it first, or choose another name")
    for other in filter(None, parts):
        if (other + "/").startswith(part + "/") or (part + "/").startswith(other + "/"):
            text = "part %s cannot be beside part %s: one would be inside the other" % (part, other)
            raise MapFileError("part", path, text, "choose another name")
    components = part.split("/")
    for depth in range(1, len(components) + 1):
        place = "/".join(components[:depth])
        if not exists(file["/"], place):
            return
        way, _, name = place.rpartition("/")
        group = is_group_of_this_file(file["/" + way], name)
        last = depth == len(components)
        if not group or last and (len(file["/" + place]) or len(file["/" + place].attrs)):
            raise _is_there(path, place, "choose another name")


def _is_there(path, part, hint):
    return MapFileError("exists", path, "there is %s in it already" % ("/" + part), hint)


def _parent(file, part):
    way, _, name = part.rpartition("/")
    return file["/" + way], name


def _remove_empty_groups(writer, file, part):
    """Those on the way to a part that is gone which say nothing."""
    way = part.rpartition("/")[0]
    while way and not len(file["/" + way]) and not len(file["/" + way].attrs):
        writer.remove(*_parent(file, way))
        way = way.rpartition("/")[0]


def _compare(path, writer, source, file):
    writer.check_written(file)
    written = writer.removed, writer.created, writer.moved, writer.changed
    RawComparison(path, *written).check(source, file)


def _check_parts(path, stream, expected):
    with reading_stream(stream, path) as file:
        found = set(find_parts(file, path))
    if found != set(expected):
        raise not_the_same(path, "parts " + ", ".join(sorted(found ^ set(expected)))[:200])
