"""The labels of several maps, by the UUID of their geometry, and of geometries without a map."""
import contextlib
import os
import threading
from typing import Any, Dict, FrozenSet, List, Mapping, Optional, Set, Tuple
from urllib.parse import quote, unquote

from mesh_msgs_hdf5.files.confine import confined_path
from mesh_msgs_hdf5.label_manager.dat_files import dat_uuids, read_dat_folder
from mesh_msgs_hdf5.labels.label_edits import LabelEdits, frozen
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Label

_SUFFIX = ".labels.journal"
_MAX_NAME = 200  # bytes; other names are made of it
_THE_ONLY_ONE = ("", "mesh")
_MAX_LOOSE = 256


class _DatBase:
    """A base without a map (see LabelBase): the .dat files of label_manager 1.x in the folder, if
    there are some. They are only read: edits of them, deletions too, are in the journal.

    Attribute notes: sentences for the user.
    """

    part: Optional[str] = None
    face_count: Optional[int] = None

    def __init__(self, path: str, uuid: str, folder: str) -> None:
        self.path, self.uuid = path, uuid
        self.notes: List[str] = []
        self._labels: Dict[str, Label] = {}
        if os.path.isdir(os.path.join(folder, uuid)):
            self._read(folder, uuid)
        self.names: FrozenSet[str] = frozenset(self._labels)

    def _read(self, folder, uuid):
        try:
            if uuid not in dat_uuids(folder):
                return
            found = read_dat_folder(folder, uuid)
        except MapFileError as error:
            self.notes.append("not read: %s" % error)
            return
        self._labels = {text: frozen(Label(faces)) for text, faces in found.labels.items()}
        text = "%d labels of label_manager 1.x are read from %s"
        self.notes.append(text % (len(self._labels), os.path.join(folder, uuid)))
        self.notes += ["not read: %s" % problem for problem in found.problems]

    def refresh(self) -> bool:
        return False

    def get(self, text: str) -> Optional[Label]:
        return self._labels.get(text)

    def all(self) -> Dict[str, Label]:
        return dict(self._labels)


class LooseLabels(LabelEdits):
    """The interface of LabelStore for a UUID without a map.

    All labels are in a journal <uuid>.labels.journal in a folder, which stays, on top of those that
    label_manager 1.x has left there. Face indices are not checked against a mesh. dirty is False,
    save() does nothing.
    """

    def __init__(
        self, folder: PathLike, uuid: str, owner_info: Optional[Mapping[str, Any]] = None
    ) -> None:
        """Make the folder if it is not there. Raises MapFileError.

        Others may write to the folder (/tmp): a journal that leads out of it is refused.
        """
        folder = os.path.abspath(os.fsdecode(folder))
        name = _file_name(folder, uuid)
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            raise MapFileError(
                "save", folder, "the folder cannot be made: %s" % error.strerror, "name another one"
            ) from error
        path = confined_path(folder, name, suffixes=(".journal",))
        base = _DatBase(path, uuid, folder)
        super().__init__(base, path, owner_info)
        self.notes[:0] = base.notes

    @property
    def dirty(self) -> bool:
        """Nothing is waiting for a map file."""
        return False

    def save(self) -> int:
        """Nothing to do: every edit is where it stays."""
        return 0


def loose_uuids(folder: PathLike) -> List[str]:
    """The UUIDs that have such labels in a folder, sorted; none if it cannot be read."""
    found: List[str] = []
    with contextlib.suppress(MapFileError, OSError):
        found += dat_uuids(folder)
    with contextlib.suppress(OSError):
        for name in os.listdir(folder):
            uuid = unquote(name[: -len(_SUFFIX)])
            if name.endswith(_SUFFIX) and quote(uuid, safe="") + _SUFFIX == name:
                found.append(uuid)
    return sorted(set(found))


def _file_name(folder, uuid):
    """A UUID may be any text: what is no plain character is escaped."""
    try:
        name = quote(uuid, safe="")
    except UnicodeEncodeError:
        name = ""
    if not 0 < len(name) <= _MAX_NAME:
        raise MapFileError(
            "uuid", folder, "a mesh has the uuid %r" % uuid[:80], "give it a short one"
        )
    return name + _SUFFIX


class LabelMaps:
    """The labels of all maps that are added, and of all other UUIDs that labels come for.

    Labels for a UUID without a map are kept in a folder (see LooseLabels), and move into a map of
    that UUID when it is added. Safe for threads.
    """

    def __init__(self, folder: PathLike, owner_info: Optional[Mapping[str, Any]] = None) -> None:
        """folder: made when it is needed. Labels that are in it already are taken over."""
        self.folder = os.path.abspath(os.fsdecode(folder))
        self._notes: List[str] = []
        self._said: Set[str] = set()  # of what is bad in the files
        self._owner_info = owner_info
        self._lock = threading.RLock()
        self._maps: Dict[str, LabelStore] = {}
        self._loose: Dict[str, LooseLabels] = {}
        known = loose_uuids(self.folder)
        for uuid in known[: _MAX_LOOSE + 1]:  # the first of too many says so
            try:
                self._make_loose(uuid)
            except MapFileError as error:
                self._notes.append(str(error))

    def add(self, path: PathLike, part: Optional[str] = None) -> LabelStore:
        """Take in the labels of a map, and those that came before it. Raises MapFileError."""
        store = LabelStore(path, part, self._owner_info)
        with self._lock:
            if store.uuid in self._maps:
                store.close()
                raise MapFileError(
                    "exists",
                    path,
                    "its geometry is that of %s: a UUID stands for one map"
                    % self._maps[store.uuid].path,
                    "name one of them",
                )
            self._maps[store.uuid] = store
            self._notes += ["%s: %s" % (store.path, note) for note in store.notes]
            if store.uuid in self._loose and store.is_owner:
                self._notes += self._adopt(store, self._loose[store.uuid])
        return store

    def move_to_the_only_map(self) -> None:
        """Labels for "mesh", as clients of 1.x call every geometry, belong to the only map,
        once all are added."""
        with self._lock:
            stores = list(self._maps.values())
            if len(stores) == 1 and stores[0].is_owner and "mesh" in self._loose:
                self._notes += self._adopt(stores[0], self._loose["mesh"])

    def taken_notes(self) -> List[str]:
        """Sentences for the user, each given once."""
        with self._lock:
            notes, self._notes = self._notes, []
            stores: List[LabelEdits] = [*self._maps.values(), *self._loose.values()]
            for store in stores:
                found = [note for note in store.file_notes() if note not in store.notes]
                bad = ["%s: %s" % (store.path, note) for note in found]
                notes += [note for note in bad if note not in self._said]
                self._said.update(bad)
        return notes

    def uuids(self) -> List[str]:
        """Of the maps, then of the others."""
        with self._lock:
            return list(dict.fromkeys([*self._maps, *self._loose]))

    def is_known(self, uuid: str) -> bool:
        """True if find_or_make() would make nothing."""
        with self._lock:
            if uuid in self._maps or uuid in self._loose:
                return True
            return uuid in _THE_ONLY_ONE and len(self._maps) == 1

    def find(self, uuid: str) -> LabelEdits:
        """The labels of a geometry; "" and "mesh" are the only one.

        Raises MapFileError (uuid), which names the known ones.
        """
        with self._lock:
            if uuid in self._maps:
                return self._maps[uuid]
            if uuid in self._loose:
                return self._loose[uuid]
            candidates = self._maps or self._loose
            if uuid in _THE_ONLY_ONE and len(candidates) == 1:
                return next(iter(candidates.values()))
            known = self.uuids()
        shown = ", ".join(known[:20]) + (", ..." if len(known) > 20 else "")
        if uuid in _THE_ONLY_ONE and known:
            text = "there are several meshes"
        else:
            text = "there is no mesh of uuid %r" % uuid[:80]
        raise MapFileError("uuid", self.folder, text, "known: %s" % (shown or "none"))

    def find_or_make(self, uuid: str) -> LabelEdits:
        """Those that labels of this UUID are added to; a new one gets labels in the folder.

        "" and "mesh" are the only map; without maps, "mesh" is a name like any other. Raises
        MapFileError.
        """
        with self._lock:
            if uuid and uuid not in (_THE_ONLY_ONE if self._maps else ()):
                if uuid not in self._maps and uuid not in self._loose:
                    self._make_loose(uuid)
            return self.find(uuid)

    def import_folder(self, folder: PathLike) -> List[str]:
        """Add the labels of label_manager 1.x in a folder; returns a sentence for each thing done.

        Faces are added to labels that are there already, so that doing it twice changes nothing.
        Those of a folder "mesh" belong to the only map. Raises MapFileError if there are none.
        """
        uuids = dat_uuids(folder)
        if not uuids:
            raise MapFileError(
                "missing", folder, "it has no folders of .dat files", "name that of label_manager"
            )
        done = []
        for uuid in uuids:
            found = read_dat_folder(folder, uuid)
            done += ["not imported: %s" % problem for problem in found.problems]
            count = 0
            try:
                labels = self.find_or_make(uuid)
            except MapFileError as error:
                done.append("not imported: %s: %s" % (uuid, error))
                continue
            for text, faces in found.labels.items():
                try:
                    labels.set(text, faces, override=False)
                    count += 1
                except MapFileError as error:
                    done.append("not imported: %s/%s.dat: %s" % (uuid, text, error))
            done.append("%d labels of uuid %s imported to %s" % (count, uuid, labels.path))
        return done

    def save(self) -> Tuple[List[str], List[str]]:
        """Put all edits into the map files: (what was saved, what was not) as sentences."""
        with self._lock:
            stores = list(self._maps.values())
        saved, failed = [], []
        for store in stores:
            try:
                count = store.save() if store.dirty else 0
            except MapFileError as error:
                failed.append(str(error))
                continue
            if count:
                saved.append("%d labels saved to %s" % (count, store.path))
        return saved, failed

    def close(self) -> None:
        """Let others own the labels; what is not saved stays in the journals."""
        with self._lock:
            for labels in [*self._maps.values(), *self._loose.values()]:
                labels.close()

    def _make_loose(self, uuid):
        if len(self._loose) >= _MAX_LOOSE:
            raise MapFileError(
                "size",
                self.folder,
                "it has labels for %d UUIDs without a map, no more are kept" % _MAX_LOOSE,
                "name the map files",
            )
        self._loose[uuid] = LooseLabels(self.folder, uuid, self._owner_info)
        self._notes += self._loose[uuid].notes

    def _adopt(self, store, loose):
        """Move labels into the map that they belong to; what it refuses stays where it is."""
        if not loose.is_owner:
            return ["%s: not moved: %s" % (loose.path, loose.refusal)]
        notes, moved = [], 0
        for text, label in loose.all().items():
            try:
                store.set(text, label.faces, label.color, override=False)
                loose.delete(text)
                moved += 1
            except MapFileError as error:
                notes.append("not moved: %s" % error)
        if moved or notes:  # else they were moved before, or deleted
            notes.append("%d labels moved from %s to %s" % (moved, loose.path, store.path))
        if not loose.names():
            loose.close()
            del self._loose[loose.uuid]
        return notes
