"""What becomes of the journals of label edits when a map file gets a new content."""
import os
from typing import Callable, Dict, List, Mapping, NamedTuple, Optional
from urllib.parse import quote, unquote

from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.labels.journal_files import open_existing
from mesh_msgs_hdf5.labels.journal_reading import OwnedError, content_of
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_SUFFIX = ".journal"


class FoundJournal(NamedTuple):
    """A journal beside a map file: of which part, of which geometry (None: it does not say), with
    how many label edits."""

    path: str
    part: str
    uuid: Optional[str]
    edits: int


def journals_of(path: PathLike) -> List[FoundJournal]:
    """The journals with edits beside a map file, of all parts, also those that it does not have.

    Raises MapFileError for one that cannot be read.
    """
    path = os.path.realpath(os.fsdecode(path))
    folder, name = os.path.split(path)
    found = []
    try:
        beside = sorted(os.listdir(folder or "."))
    except OSError:  # whoever writes there says so
        return found
    for other in beside:
        part = _part_of(name, other)
        if part is None or os.path.exists(os.path.join(folder, other[: -len(_SUFFIX)])) and part:
            continue  # that of another map, whose name begins like this one's
        place = os.path.join(folder, other)
        descriptor = open_existing(place, os.O_RDONLY)
        if descriptor is None:
            continue
        try:
            content = content_of(descriptor, place, None, None)
        finally:
            os.close(descriptor)
        count = len(content.edits) + len(content.damaged)
        if count:
            part = "mesh" if not part else "" if part == "/" else part
            found.append(FoundJournal(place, part, content.uuid, count))
    return found


def _part_of(name: str, other: str) -> Optional[str]:
    """The part of a journal of this name, "" that without one; None where it is none of the map."""
    if not (other.startswith(name + ".") and other.endswith(_SUFFIX)):
        return None
    middle = other[len(name) + 1 : -len(_SUFFIX) + 1]
    if not middle:
        return ""
    quoted = middle[:-1]
    part = unquote(quoted)
    return part if middle.endswith(".") and quote(part, safe="") == quoted else None


def check_journals(
    path: PathLike, new_uuids: Callable[[], Mapping[str, str]], part: Optional[str] = None
) -> None:
    """Refuse to put a new content into a map file of which label edits would be lost.

    new_uuids: gives part -> UUID of its new geometry. part: only its journal counts. Raises
    MapFileError (journal).
    """
    journals = [found for found in journals_of(path) if part is None or found.part == part]
    uuids = new_uuids() if journals else {}
    for found in journals:
        if found.uuid is None or uuids.get(found.part) != found.uuid:
            raise MapFileError(
                "journal",
                path,
                "%d label edits of the mesh %s in it stand in %s alone, and would be lost"
                % (found.edits, found.part or "/", os.path.basename(found.path)),
                "put them into the map: mesh_tool repack FILE (a node that owns them: its service "
                "save_map); or move that journal away",
            )


def uuids_of(path: PathLike) -> Dict[str, str]:
    """Part -> UUID of a map file. Raises MapFileError."""
    return {part: IsolatedMapFile(path, part or "/").uuid for part in isolated("parts", path)}


def save_journals(path: PathLike, part: Optional[str] = None) -> List[str]:
    """Put the label edits in the journals of a map file into it; returns notes.

    part: only those of this part. Those that another process owns stay with it. Raises
    MapFileError, then those of some parts may be in the file.
    """
    notes = []
    for found in journals_of(path):
        if part is not None and found.part != part:
            continue
        try:
            with LabelStore(path, found.part or "/", {"program": "mesh_tool"}) as store:
                if store.refusal is None:
                    store.save()
                elif isinstance(store.refusal, OwnedError):
                    text = "%d label edits stay in %s, of which another program takes care: %s"
                    notes.append(text % (found.edits, found.path, store.refusal.message))
                else:
                    raise store.refusal
        except MapFileError as error:
            if error.code not in ("journal", "no_mesh", "part", "version"):
                raise
            notes.append("left as it is: %s" % error)
    return notes
