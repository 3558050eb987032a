"""Labels with edits on top that are safe in a journal."""
import datetime
import os
import socket
import threading
from typing import Any, Dict, Mapping, Optional

import numpy as np

from mesh_msgs_hdf5.checks.check_annotations import checked_label
from mesh_msgs_hdf5.errors import MapFileError
from mesh_msgs_hdf5.labels.journal import Journal
from mesh_msgs_hdf5.labels.journal_reading import OwnedError
from mesh_msgs_hdf5.labels.label_base import frozen
from mesh_msgs_hdf5.labels.label_view import LabelView
from mesh_msgs_hdf5.mesh import Color, Label
from mesh_msgs_hdf5.reading.label_reader import MAX_LABELS

_SMALL = 16 << 20  # bytes of a journal that are not worth writing it anew
_TRIES = 5


class LabelEdits(LabelView):
    """The labels of one mesh. See LabelStore, which is what to use for a map.

    base: labels without the edits (LabelBase, or what has its members).
    """

    def __init__(
        self,
        base: Any,
        journal_path: str,
        owner_info: Optional[Mapping[str, Any]] = None,
        read_only: bool = False,
    ) -> None:
        super().__init__(base, journal_path)
        self._saving = threading.Lock()
        self._journal: Optional[Journal] = None
        self._being_saved: Dict[str, Optional[Label]] = {}
        self._refusal: Optional[MapFileError] = None
        self._compact_at = _SMALL
        self._owner_info = dict(owner_info or {})
        self.read_only = read_only
        with self._lock:
            if read_only:
                self._follow()
            else:
                self._become_owner()

    @property
    def is_owner(self) -> bool:
        """True if this object may change the labels."""
        return self._journal is not None

    @property
    def owner(self) -> Optional[Dict[str, Any]]:
        """What is known of another process that owns the labels; None if there is none."""
        return None if self._journal is not None else super().owner

    @property
    def refusal(self) -> Optional[MapFileError]:
        """Why labels cannot be changed at the moment; None if they can."""
        return None if self._journal is not None else self._refusal

    @property
    def dirty(self) -> bool:
        """True if edits made here are not in the map file yet (they are safe in the journal)."""
        with self._lock:
            return self._journal is not None and bool(self._needed())

    def set(
        self, text: str, faces: Any, color: Optional[Color] = None, override: bool = True
    ) -> Label:
        """Label faces; returns the label as it is now, once it is safe on the disk.

        faces: (K,) integers from 0 to F - 1 in any order; a label holds each once, ascending.
        override: these faces replace those of a label of that text; False: they are added. No
        faces clear the label (override), which stays, or change nothing. color: None keeps the one
        it has.

        Raises MapFileError (label, index, dtype, shape, value: what was given; owned: by another
        process; save: it is not safe); then nothing was changed.
        """
        label = self._checked(text, faces, color)
        with self._lock:
            self._own()
            old = self._current(text)
            if old is not None:
                color = old.color if label.color is None else label.color
                faces = label.faces if override else np.union1d(old.faces, label.faces)
                label = Label(faces.astype(np.uint32, copy=False), color)
                if old.color == color and np.array_equal(old.faces, label.faces):
                    return old
            elif len(self._names) >= MAX_LABELS:
                raise MapFileError(
                    "size", self.path, "it has %d labels, no more are read" % MAX_LABELS, ""
                )
            self._log(text, frozen(label))
            return label

    def set_color(self, text: str, color: Optional[Color]) -> Label:
        """Give a label a color of its own, or none; returns the label as it is now.

        Raises MapFileError (label, value, owned, save); then nothing was changed.
        """
        with self._lock:
            self._own()
            old = self._current(text)
            if old is None:
                raise self._unknown(text)
            label = self._checked(text, old.faces, color)
            if old.color == label.color:
                return old
            self._log(text, frozen(label))
            return label

    def delete(self, text: str) -> Label:
        """Remove a label; returns what it was. Raises MapFileError (label, owned, save)."""
        with self._lock:
            self._own()
            label = self._current(text)
            if label is None:
                raise self._unknown(text)
            self._log(text, None)
            return label

    def save(self) -> int:
        """Put all edits into the map file in one step, then empty the journal.

        Edits made meanwhile are not held up, and stay for the next time. If another program has
        saved the map, its changes stay. Returns the number of labels that were changed. Raises
        MapFileError; then file and journal are as they were.
        """
        with self._saving:
            with self._lock:
                self._own()
                saved = self._being_saved = self._needed()
            if not saved:
                return 0
            for tries_left in reversed(range(_TRIES)):
                try:
                    self._base.fold(saved)
                    break
                except MapFileError as error:
                    if error.code != "changed" or not tries_left:
                        raise
                    with self._lock:  # saved by another program: if the mesh is the same, again
                        self._base.refresh()
            with self._lock:
                self._forget(saved)
                self._being_saved = {}
            return len(saved)

    def close(self) -> None:
        """Let others own the labels. Edits that are not saved stay in the journal."""
        with self._saving, self._lock:
            if self._journal is not None:
                self._journal.close(remove=not self._needed())
                self._journal = None
            self.read_only = True
            self._refusal = MapFileError("save", self.path, "its labels are closed", "")

    def __enter__(self):
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _become_owner(self):
        """Take over the journal, or else note why not and look on."""
        owner = {
            "pid": os.getpid(),
            "host": socket.gethostname(),
            "time": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
            **self._owner_info,
        }
        base = self._base
        try:
            journal = Journal(
                self.journal_path, base.uuid, base.part, base.face_count, owner, like=base.path
            )
        except MapFileError as error:
            if error.code in ("journal", "version"):
                raise
            if not isinstance(error, OwnedError) and self._refusal is None:
                self.notes.append("labels cannot be changed: %s" % error)
            self._refusal = error
            self._follow()
            return
        self._journal, self._edits = journal, dict(journal.content.edits)
        self.notes += journal.notes
        if self._edits:
            self.notes.append(
                "%d label edits that are not in the map file yet are taken from %s"
                % (len(self._edits), self.journal_path)
            )
        base.refresh()
        self._find_names()

    def _refresh(self):
        if self._journal is None:
            super()._refresh()
        elif self._base.refresh():
            self._find_names()

    def _own(self):
        if self._journal is None and not self.read_only:
            self._become_owner()
        self._refresh()
        if self._journal is None:
            text = "its labels were opened to be read only"
            raise self._refusal or MapFileError("save", self.path, text, "")

    def _checked(self, text, faces, color):
        limit = 1 << 32 if self.face_count is None else self.face_count
        faces = np.asarray(faces)
        if faces.size and faces.ndim == 1 and faces.dtype.kind in "iu":
            if faces.min() >= 0 and faces.max() < limit:  # errors speak of the order given
                faces = np.unique(faces)
        label = checked_label(self.path, text, Label(faces, color), limit)
        return Label(np.unique(label.faces), label.color)

    def _log(self, text, label):
        if not self._journal.is_in_place():  # somebody removed the file
            self._journal.rewrite(self._edits)
        self._journal.append(text, label)
        self._edits[text] = label
        if label is None:
            self._names.discard(text)
        else:
            self._names.add(text)
        if self._journal.size > self._compact_at:
            self._compact()

    def _needed(self):
        """The edits without deletions of labels that are not in the map file, nor get there now."""
        there = self._base.names.union(self._being_saved)
        return {k: v for k, v in self._edits.items() if v is not None or k in there}

    def _compact(self):
        """Write the journal anew with the last edit of each label alone."""
        edits = self._needed()
        try:
            self._journal.rewrite(edits)
            self._edits = edits
        except MapFileError as error:  # no room: every edit is safe in the long one
            self.notes.append(str(error))
        self._compact_at = max(_SMALL, 4 * self._journal.size)

    def _forget(self, saved):
        """Drop from the journal what is in the map, but not what was changed once more since."""
        self._base.refresh()
        rest = {
            text: label
            for text, label in self._needed().items()
            if text not in saved or saved[text] is not label
        }
        if rest or not self._journal.is_in_place():
            self._journal.rewrite(rest)
        else:
            self._journal.clear()
        self._edits = rest
        self._find_names()
        self._compact_at = _SMALL
