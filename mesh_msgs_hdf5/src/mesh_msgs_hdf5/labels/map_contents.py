"""Maps as everybody is to see them: what is in the file, with the label edits of its journal."""
import os
import threading
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Set, Tuple

import numpy as np

from mesh_msgs_hdf5.files.save import stamp
from mesh_msgs_hdf5.formats.any_mesh import Members, Opened, is_map_file, open_members
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.labels.label_store import LabelStore, journal_path, label_file
from mesh_msgs_hdf5.model.edit import LabelChanges
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Label, Mesh

_TRIES = 5


class MapContents:
    """The members of a map file (see MapFile), read when they are asked for.

    Its labels are those of the file with the edits that the owner of its journal has made since,
    so that an area that was drawn in RViz a moment ago is there. All raise MapFileError. Safe for
    threads.
    """

    def __init__(
        self,
        members: Members,
        is_map_file: bool,
        on_note: Optional[Callable[[str], Any]] = None,
    ) -> None:
        """
        Args:
            members: of the map.
            is_map_file: False for a mesh in memory, whose labels are its own.
            on_note: is told once of each thing that is bad in the file, and was mended or left out.
        """
        self._members = members
        self._is_map_file = is_map_file
        self._on_note = on_note
        self._said: Set[str] = set()
        self._store: Optional[LabelStore] = None
        self._lock = threading.Lock()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._members, name)

    def __enter__(self) -> "MapContents":
        self._members.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._members.__exit__(*error)

    def label_names(self) -> List[str]:
        """The texts of all labels, tree_2 before tree_10."""
        store = self._journalled()
        return self._members.label_names() if store is None else store.names()

    def label(self, text: str) -> Label:
        """One label."""
        store = self._journalled()
        return self._told(self._members.label(text) if store is None else store.get(text))

    def labels(self) -> Dict[str, Label]:
        """Text -> label, of all: quicker than several of them one by one."""
        store = self._journalled()
        return self._told(self._members.labels() if store is None else store.all())

    def read(self, members: Optional[Iterable[str]] = None) -> Mesh:
        """As MapFile.read."""
        members = None if members is None else tuple(members)
        mesh = self._members.read(members)
        if members is None or "labels" in members:
            store = self._journalled()
            mesh.labels = mesh.labels if store is None else store.all()
        return mesh

    def label_changes(self) -> LabelChanges:
        """What makes the labels of the file those of labels(): text -> label, None for deleted."""
        store = self._journalled()
        if store is None:
            return {}
        if store.path == os.path.realpath(self._members.path):
            return store.unsaved
        old, new = self._members.labels(), store.all()  # they are kept in a file beside it
        changes: LabelChanges = {text: None for text in old if text not in new}
        changes.update((k, v) for k, v in new.items() if k not in old or not _same(old[k], v))
        return changes

    @property
    def unsaved_count(self) -> int:
        """How many labels are in the journal otherwise than in the file."""
        store = self._journalled()
        return 0 if store is None else len(store.unsaved)

    @property
    def label_notes(self) -> List[str]:
        """Sentences about a journal that cannot be read, or not wholly."""
        store = self._journalled()
        if store is None:
            return []
        store.names()
        return list(store.notes)

    def label_store(self) -> LabelStore:
        """Labels and journal of the map file, which are only read.

        Raises:
            MapFileError: also where the mesh is no map file.
        """
        if not self._is_map_file:
            reason = "it is no map file, so its labels cannot be edited"
            raise MapFileError("value", self._members.path, reason, "mesh_tool import makes one")
        return self._labels()

    def labels_version(self) -> Any:
        """Something that is not equal to what it was when labels may have changed since.

        Looks at the time stamps of files, at the contents of none.
        """
        if not self._is_map_file:
            return 0
        store = self._labels()
        return stamp(store.path), stamp(store.journal_path)

    def _told(self, found: Any) -> Any:
        """What was found; what is bad in the file has been told."""
        self.tell_notes()
        return found

    def tell_notes(self) -> None:
        """Tell what is bad in the file, as far as it was read, and was not told yet."""
        if self._on_note is None:
            return
        notes = list(self._members.notes)
        notes += [] if self._store is None else self._store.file_notes()
        for note in notes:
            if note not in self._said:
                self._said.add(note)
                self._on_note(note)

    def _journalled(self) -> Optional[LabelStore]:
        """Labels with a journal; None where those of the members are all there are now."""
        if not self._is_map_file:
            return None
        if self._store is None and not self._is_journalled():
            return None
        return self._labels()

    def _is_journalled(self) -> bool:
        members = self._members
        target = label_file(members.path, members.schema)
        if target != os.path.realpath(members.path) and os.path.exists(target):
            return True
        return os.path.lexists(journal_path(target, members.part))

    def _labels(self) -> LabelStore:
        with self._lock:
            if self._store is None:
                members = self._members
                store = LabelStore(members.path, members.part or "/", read_only=True)
                if (store.uuid, store.face_count) != (members.uuid, members.face_count):
                    reason = "another program has replaced the mesh"
                    raise MapFileError("changed", members.path, reason, "open it again")
                self._store = store
            return self._store


def _same(one: Label, other: Label) -> bool:
    return one.color == other.color and np.array_equal(one.faces, other.faces)


def open_map(
    path: PathLike, part: Optional[str] = None, origin: Optional[Sequence[float]] = None
) -> Opened:
    """As open_members; the labels of a map file are those with the edits of its journal."""
    opened = open_members(path, part, origin)
    return opened._replace(members=MapContents(opened.members, opened.is_map))


def read_map(
    path: PathLike, part: Optional[str] = None, **options: Any
) -> Tuple[Mesh, ImportReport]:
    """As read_mesh; the labels of a map file are those with the edits of its journal."""
    path = os.fsdecode(path)
    if not is_map_file(path):
        return read_mesh(path, part, **options)
    for _ in range(_TRIES):
        contents = MapContents(IsolatedMapFile(path, part), True)
        journal = journal_path(path, contents.part)
        before = stamp(path), stamp(journal)
        changes, notes = contents.label_changes(), contents.label_notes
        mesh, report = read_mesh(path, contents.part or "/", label_changes=changes, **options)
        if before == (stamp(path), stamp(journal)):  # else its owner has put edits into the file
            break
    report.notes[:0] = notes
    return mesh, report


def all_label_changes(path: PathLike) -> Tuple[Dict[str, LabelChanges], List[str]]:
    """(part -> MapContents.label_changes() where there are any, notes) of all parts of a map file.

    Raises MapFileError.
    """
    found: Dict[str, LabelChanges] = {}
    notes: List[str] = []
    for part in isolated("parts", path):
        contents = MapContents(IsolatedMapFile(path, part or "/"), True)
        changes = contents.label_changes()
        notes += contents.label_notes
        if changes:
            found[part] = changes
    return found, notes
