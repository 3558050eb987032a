"""Changes of the parts of a map file by a command, and of the journals that belong to them."""
import contextlib
import os
from typing import Any, Dict, Iterable, Iterator, List, Optional, Tuple

from mesh_msgs_hdf5.commands.replaced_output import lost_with
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.labels.map_contents import MapContents, open_map
from mesh_msgs_hdf5.labels.replaced_maps import check_journals, save_journals
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh


def part_summaries(path: str) -> List[Dict[str, Any]]:
    """What is to be said of each part of a map file; no arrays are read. Raises MapFileError."""
    entries = []
    for part in isolated("parts", path):
        with MapContents(IsolatedMapFile(path, part or "/"), True) as file:
            entry = {"part": part, "schema": file.schema, "vertices": file.vertex_count}
            entry.update(faces=file.face_count, labels=len(file.label_names()))
            entry.update(unsaved_labels=file.unsaved_count, frame_id=file.frame_id)
            entries.append(dict(entry, uuid=file.stored_uuid))
    return entries


def put(
    path: str, mesh: Mesh, part: str, force: bool, compression: str = "gzip"
) -> Tuple[List[str], bool]:
    """Add a mesh to a map file, or replace one (force); returns notes and whether it did.

    Raises MapFileError, also where label edits of the replaced mesh would be lost.
    """
    part = _plain(part)
    replaced = part in isolated("parts", path)
    if force or not replaced:
        check_journals(path, lambda: {part: mesh.uuid}, part)
    lost = lost_with(path, mesh, part) if replaced and force else []
    notes = lost + isolated("put_part", path, mesh, part, force, compression)
    return notes + save_journals(path, part), replaced


def renamed(path: str, part: str, new: str) -> None:
    """Give a part another name; the edits in its journal are put into the file first."""
    part, new = _plain(part), _plain(new)
    check_journals(path, dict, new)
    with _owned(path, part) as labels:
        labels.save()
        IsolatedMapFile(path, part).rename_part(new)


def deleted(path: str, parts: Iterable[str], last: bool) -> List[str]:
    """Remove parts with their journals; returns notes. Raises MapFileError."""
    names, notes = list(dict.fromkeys(_plain(part) for part in parts)), []
    with contextlib.ExitStack() as opened:
        stores = [opened.enter_context(_owned(path, part)) for part in names]
        unsaved = [len(store.unsaved) for store in stores]
        isolated("delete_parts", path, names, last)
        for part, store, count in zip(names, stores, unsaved):
            store.discard()
            if count:
                notes.append("with %d label edits of part %s in its journal" % (count, part))
    return notes


def copied(path: str, origin: str, part: str, new: Optional[str]) -> Tuple[str, List[str]]:
    """Copy a part of origin, with the edits of its journal; returns its name and notes."""
    if new is None and os.path.realpath(origin) == os.path.realpath(path):
        raise MapFileError("part", path, "the copy needs a name of its own", "NAME NEW")
    part = _plain(part)
    new = part if new is None else _plain(new)
    contents = open_map(origin, part).members
    check_journals(path, dict, new)
    contents.copy_part(new, os.path.abspath(path), contents.label_changes())
    return new, contents.label_notes


def _plain(part: str) -> str:
    return "/".join(filter(None, part.split("/")))


@contextlib.contextmanager
def _owned(path: str, part: str) -> Iterator[LabelStore]:
    """The labels of a part, while no node can change them."""
    file = IsolatedMapFile(path, part or "/")
    if file.schema != "S1":
        message = "it is of schema %s, which is only read" % file.schema
        raise MapFileError("schema", path, message, "mesh_tool convert IN.h5 OUT.h5")
    with LabelStore(path, file.part or "/", {"program": "mesh_tool"}) as store:
        if store.refusal is not None:
            raise store.refusal
        yield store
