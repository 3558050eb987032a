"""The labels of a map: those in its file, with the edits of its journal."""
import os
from typing import Any, Callable, Mapping, Optional
from urllib.parse import quote

from mesh_msgs_hdf5.errors import PathLike
from mesh_msgs_hdf5.labels.label_base import Identity, LabelBase, label_target
from mesh_msgs_hdf5.labels.label_edits import LabelEdits

__all__ = ["LabelStore", "journal_path", "label_target"]


def journal_path(path: PathLike, part: str = "mesh") -> str:
    """The journal of a part of a map file: garden.h5.journal, or garden.h5.<part>.journal."""
    path = os.path.realpath(os.fsdecode(path))
    return path + ("" if part == "mesh" else "." + quote(part or "/", safe="")) + ".journal"


class LabelStore(LabelEdits):
    """The labels of a map or mesh, of which one process at a time is the owner.

    What an edit returns is on the disk: in the journal at once, in the map file after save(). Who
    is not the owner sees the owner's edits, and becomes the owner with its next edit once that
    process has ended. Safe for threads. Two parts of a file have two stores.

    map_path: a map file of any schema, or a mesh; labels of what is no map of schema S1 go to the
    file of label_target(), which save() makes. part: as in MapFile. owner_info: what others shall
    know of this process. read_only: never the owner; no file is made. identity: (UUID, number of
    faces) of a mesh, where known: saves reading it. map_file: what opens map files
    (map_access.open_map).

    Raises MapFileError, for example journal: there are edits of another mesh in its journal. Why
    labels cannot be changed otherwise (read-only folder, other owner) is in refusal; notes has
    sentences for the user. Attributes: path (the map file that save() changes), part, uuid,
    face_count, journal_path, is_owner, owner, refusal, notes, read_only, dirty.
    """

    def __init__(
        self,
        map_path: PathLike,
        part: Optional[str] = None,
        owner_info: Optional[Mapping[str, Any]] = None,
        read_only: bool = False,
        identity: Optional[Identity] = None,
        map_file: Optional[Callable[..., Any]] = None,
    ) -> None:
        base = LabelBase(map_path, part, identity, map_file)
        journal = journal_path(base.path, base.part)
        super().__init__(base, journal, owner_info, read_only)
