"""Builds a map file, verifies it by reading it again, and puts it in its place.

A file is built in memory; where what is carried over from an old one is large (raw scans), it is
built on disk, as the temporary file that will take the old one's place.
"""
import contextlib
import os
import tempfile
from dataclasses import fields, is_dataclass
from typing import Any, Callable, Iterator, Optional

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import checked_mesh
from mesh_msgs_hdf5.files.save import Stamp, save_file
from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.map_file.writing.check_edit import checked_edit
from mesh_msgs_hdf5.map_file.writing.edit_writer import apply_edit
from mesh_msgs_hdf5.map_file.writing.hdf5_stream import (
    Stream,
    building,
    copied,
    memory_stream,
    reading_stream,
)
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter, not_the_same
from mesh_msgs_hdf5.map_file.writing.part_names import PartNames
from mesh_msgs_hdf5.map_file.writing.part_writer import PartWriter
from mesh_msgs_hdf5.map_file.writing.raw_compare import RawComparison
from mesh_msgs_hdf5.map_file.writing.raw_copy import copy_everything
from mesh_msgs_hdf5.map_file.writing.references import carry_references
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Features, Mesh

MEMORY_BUDGET = 256 << 20  # bytes of an old file that are carried over in memory
_SLACK_BYTES = 4 << 20  # what HDF5 needs besides the arrays
_OBJECT_BYTES = 8192  # what it needs for each


def save_mesh(path: PathLike, mesh: Mesh, part: str, overwrite: bool, compression: str) -> None:
    """Save a mesh as the only part of a new file. Raises MapFileError; then nothing was changed."""
    writer = ObjectWriter(path, compression)
    schema.new_part_path(path, part)
    with nothing_changed(path):
        mesh = checked_mesh(path, mesh)
    with nothing_changed(path), memory_stream(bytes_of(mesh)) as stream:
        with building(stream, path) as file:
            PartWriter(writer, part_group(writer, file, part)).mesh(mesh)
        verify(path, stream, writer, part, PartNames.of_mesh(mesh))
        save_file(path, copied(stream), overwrite=overwrite)


def save_edit(reader: MapReader, edit: Edit, expected: Optional[Stamp]) -> PartNames:
    """Save the open file of a reader with an edit applied; all else in it stays as it is stored.

    expected: the stamp of the file when it was opened. Returns what the part has now. Raises
    MapFileError; then the file is as it was.
    """
    path, source = reader.path, reader.file
    check_editable(reader)
    edit = checked_edit(edit, reader)
    names = PartNames.of_reader(reader).edited(edit)

    def build(stream: Stream) -> None:
        writer = ObjectWriter(path)
        with building(stream, path, source) as file:
            copy_everything(path, source, file)
            part = file["/" + reader.part]
            apply_edit(writer, part, reader, edit)
            carry_references(source, file, writer.moved, path)
        verify(path, stream, writer, reader.part, names, source)

    room = source.id.get_filesize() + bytes_of(edit)
    save_built(path, build, room, expected=expected)
    return names


def check_editable(reader: MapReader) -> None:
    """Refuse a part that is only read: code schema, or version for one of a newer program."""
    path = reader.path
    if reader.schema != "S1":
        raise MapFileError(
            "schema",
            path,
            "it is a file of schema %s, which is only read" % reader.schema,
            "rosrun mesh_msgs_hdf5 mesh_tool convert FILE.h5 NEW_FILE.h5",
        )
    if reader.schema_version > schema.VERSION:
        raise MapFileError(
            "version",
            path,
            "it was written by a newer Mesh Tools (schema %d)" % reader.schema_version,
            "use that one, or save to another file",
        )


def save_built(
    path: PathLike,
    build: Callable[[Stream], None],
    room: int,
    expected: Optional[Stamp] = None,
    overwrite: bool = True,
    compact: bool = False,
) -> None:
    """Save what build writes into a stream; room: the most bytes it may be.

    compact: it may hold much unused space, which is left out.
    """
    room += _SLACK_BYTES
    if room <= MEMORY_BUDGET:
        with nothing_changed(path), contextlib.ExitStack() as streams:
            stream = streams.enter_context(memory_stream(room))
            build(stream)
            if compact:
                loose, stream = stream, streams.enter_context(memory_stream(room))
                _compact(path, loose, stream)
            save_file(path, copied(stream), expected=expected, overwrite=overwrite)
        return

    def fill(descriptor: int) -> None:
        stream = Stream(descriptor, room)
        if not compact:
            build(stream)
            return
        folder = os.path.dirname(os.path.realpath(os.fsdecode(path)))
        with tempfile.TemporaryFile(dir=folder) as loose_file:
            loose = Stream(loose_file.fileno(), room)
            build(loose)
            _compact(path, loose, stream)

    save_file(path, fill, expected=expected, overwrite=overwrite)


def _compact(path, loose, stream):
    """Copy a file without the space that is not used."""
    with reading_stream(loose, path) as source:
        with building(stream, path, source) as file:
            copy_everything(path, source, file)
            carry_references(source, file, {}, path)
        with reading_stream(stream, path) as file:
            RawComparison(path).check(source, file)


def part_group(writer: ObjectWriter, file: h5py.File, part: str) -> h5py.Group:
    """The group of a part, which is made if it is not there."""
    group = file["/"]
    for name in schema.part_path(writer.path, part):
        group = writer.group(group, name)
    return group


def verify(
    path: PathLike,
    stream: Stream,
    writer: ObjectWriter,
    part: str,
    names: PartNames,
    source: Optional[h5py.File] = None,
) -> None:
    """Refuse a file unless it holds what was written, all else of source, and a reader sees it."""
    with reading_stream(stream, path) as file:
        writer.check_written(file)
        if source is not None:
            RawComparison(path, writer.removed, writer.created, writer.moved, writer.changed).check(
                source, file
            )
        found = PartNames.of_reader(MapReader(file, path, part))
    if found != names:
        raise not_the_same(path, found.first_difference(names))


@contextlib.contextmanager
def nothing_changed(path: PathLike) -> Iterator[None]:
    """What goes wrong with memory before a file is saved is a MapFileError."""
    try:
        yield
    except (MemoryError, OSError) as error:
        reason = getattr(error, "strerror", None) or "there is not enough memory"
        raise MapFileError(
            "save",
            path,
            "cannot be saved, nothing was changed: %s" % reason,
            "free some memory, or raise the limits of this process (ulimit)",
        ) from error


def bytes_of(value: Any) -> int:
    """An upper bound of what the arrays in a Mesh, an Edit or a dict take in a file."""
    if isinstance(value, np.ndarray):
        return 2 * value.nbytes + _OBJECT_BYTES
    if isinstance(value, Features):
        rows = _OBJECT_BYTES * len(value.locations)
        return bytes_of(value.locations) + bytes_of(value.descriptors) + rows
    if is_dataclass(value):
        return sum(bytes_of(getattr(value, field.name)) for field in fields(value))
    if isinstance(value, dict):
        return sum(bytes_of(inner) + bytes_of(key) for key, inner in value.items())
    return 10 * len(value) + 64 if isinstance(value, (str, list)) else 64
