"""Labels with the edits of a journal on top: seen by one who looks on, or changed by the owner."""
import bisect
import contextlib
import datetime
import difflib
import os
import socket
import threading
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.checks.check import checked_label
from mesh_msgs_hdf5.files.save import stamp
from mesh_msgs_hdf5.labels.journal import Journal
from mesh_msgs_hdf5.labels.journal_reading import OwnedError, is_owned, read_journal
from mesh_msgs_hdf5.model.edit import LabelChanges
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import MAX_LABELS, natural_order, split_label
from mesh_msgs_hdf5.model.mesh import Color, Label

_SMALL = 16 << 20  # bytes of a journal that are not worth writing it anew
_TRIES = 5


def frozen(label: Label) -> Label:
    """The label; its faces cannot be changed any more."""
    label.faces.setflags(write=False)
    return label


class NaturalNames:
    """Texts, each once, with tree_2 before tree_10; adding one to many takes microseconds."""

    def __init__(self, texts: Iterable[str] = ()) -> None:
        self._entries: List[Tuple[Any, str]] = sorted((natural_order(t), t) for t in set(texts))

    def __len__(self) -> int:
        return len(self._entries)

    def texts(self) -> List[str]:
        """All, in order."""
        return [text for _, text in self._entries]

    def add(self, text: str) -> None:
        """Without effect if it is there."""
        place, entry = self._place(text)
        if self._entries[place : place + 1] != [entry]:
            self._entries.insert(place, entry)

    def discard(self, text: str) -> None:
        """Without effect if it is not there."""
        place, entry = self._place(text)
        if self._entries[place : place + 1] == [entry]:
            del self._entries[place]

    def _place(self, text):
        entry = natural_order(text), text
        return bisect.bisect_left(self._entries, entry), entry


class LabelEdits:
    """The labels of one mesh, as they are at each call. See LabelStore, which is what to use for a
    map.

    base: labels without the edits (LabelBase, or what has its members). Attributes: journal_path,
    notes (sentences for the user).
    """

    def __init__(
        self,
        base: Any,
        journal_path: str,
        owner_info: Optional[Mapping[str, Any]] = None,
        read_only: bool = False,
    ) -> None:
        self._base = base
        self._lock = threading.RLock()
        self._saving = threading.Lock()
        self._edits: Dict[str, Optional[Label]] = {}
        self._names = NaturalNames()
        self._owner: Optional[Dict[str, Any]] = None  # another process, as _follow has found it
        self._marks: Any = None
        self._journal: Optional[Journal] = None
        self._being_saved: Dict[str, Optional[Label]] = {}
        self._refusal: Optional[MapFileError] = None
        self._compact_at = _SMALL
        self._mended = ""  # what was done to the journal last
        self._owner_info = dict(owner_info or {})
        self.journal_path = journal_path
        self.notes: List[str] = []
        self.read_only = read_only
        with self._lock:
            if read_only:
                self._follow()
            else:
                self._become_owner()

    @property
    def path(self) -> str:
        """The file that save() changes."""
        return self._base.path

    @property
    def uuid(self) -> str:
        """Of the geometry."""
        return self._base.uuid

    @property
    def part(self) -> Optional[str]:
        """Of the map file."""
        return self._base.part

    @property
    def face_count(self) -> Optional[int]:
        """None if the mesh is not known."""
        return self._base.face_count

    @property
    def owner(self) -> Optional[Dict[str, Any]]:
        """What is known of another process that owns the labels; None if there is none."""
        if self._journal is not None or not is_owned(self.journal_path):
            return None
        with self._lock:
            self._refresh()
            return dict(self._owner or {})

    def names(self) -> List[str]:
        """The texts of all labels, tree_2 before tree_10."""
        with self._lock:
            self._refresh()
            return self._names.texts()

    def get(self, text: str) -> Label:
        """A label; its faces cannot be changed. Raises MapFileError (label) if there is none."""
        with self._lock:
            self._refresh()
            label = self._current(text)
            if label is None:
                raise self._unknown(text)
            return label

    def all(self) -> Dict[str, Label]:
        """Text -> label, in the order of names(), but for those that cannot be read."""
        with self._lock:
            names, labels = self.names(), self._base.all()
            labels.update(self._edits)
            return {text: labels[text] for text in names if text in labels}

    def file_notes(self) -> List[str]:
        """What is wrong with labels of the file, and was mended or left out, as far as they were
        read; and what was wrong with the journal last.
        """
        with self._lock:
            return list(self._base.notes) + [self._mended] * bool(self._mended)

    def groups(self) -> List[str]:
        """The classes of all labels: their texts before the first underscore."""
        return list(dict.fromkeys(split_label(text)[0] for text in self.names()))

    def group(self, class_name: str) -> Dict[str, Label]:
        """The labels of exactly that class; empty if there is none."""
        with self._lock:
            texts = [text for text in self.names() if split_label(text)[0] == class_name]
            found = {text: self._readable(text) for text in texts}
            return {text: label for text, label in found.items() if label is not None}

    @property
    def is_owner(self) -> bool:
        """True if this object may change the labels."""
        return self._journal is not None

    @property
    def refusal(self) -> Optional[MapFileError]:
        """Why labels cannot be changed at the moment; None if they can."""
        return None if self._journal is not None else self._refusal

    @property
    def dirty(self) -> bool:
        """True if edits made here are not in the map file yet (they are safe in the journal)."""
        with self._lock:
            return self._journal is not None and bool(self._needed())

    @property
    def unsaved(self) -> LabelChanges:
        """The edits that are not in the map file yet, made here or, as far as is known, by another
        owner of the labels."""
        with self._lock:
            self._refresh()
            return self._needed()

    def set(
        self, text: str, faces: Any, color: Optional[Color] = None, override: bool = True
    ) -> Label:
        """Label faces; returns the label as it is now, once it is safe on the disk.

        faces: (K,) integers from 0 to F - 1 in any order; a label holds each once, ascending.
        override: these faces replace those of a label of that text; False: they are added. No
        faces clear the label (override), which stays, or change nothing; where there is no label
        of that text, no faces and no color make none: it may just have been deleted. color: None
        keeps the one it has.

        Raises MapFileError (label, index, dtype, shape, value: what was given; owned: by another
        process; save: it is not safe); then nothing was changed.
        """
        label = self._checked(text, faces, color)
        with self._lock:
            self._own()
            old = self._readable(text) if override else self._current(text)
            if old is not None:
                color = old.color if label.color is None else label.color
                faces = label.faces if override else np.union1d(old.faces, label.faces)
                label = Label(faces.astype(np.uint32, copy=False), color)
                if old.color == color and np.array_equal(old.faces, label.faces):
                    return old
            elif not label.faces.size and label.color is None:
                return label
            elif len(self._names) >= MAX_LABELS:
                raise MapFileError(
                    "size",
                    self.path,
                    "it has %d labels, no more are read" % MAX_LABELS,
                    "merge some",
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
        """Remove a label; returns what it was, without faces if it cannot be read.

        Raises MapFileError (label, owned, save).
        """
        with self._lock:
            self._own()
            label = self._readable(text)
            if label is None and text in self.names():
                label = Label(np.zeros(0, np.uint32))
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

    def discard(self) -> None:
        """Close the labels of a mesh that is no more: edits that are not saved are forgotten."""
        with self._lock:
            if self._journal is not None:
                self._edits = {}
        self.close()

    def close(self) -> None:
        """Let others own the labels. Edits that are not saved stay in the journal."""
        with self._saving, self._lock:
            if self._journal is not None:
                if self._needed():
                    with contextlib.suppress(MapFileError):  # it stays as it is
                        self._mend_journal()
                self._journal.close(remove=not self._needed())
                self._journal = None
            self.read_only = True
            self._refusal = MapFileError("save", self.path, "its labels are closed", "")

    def __enter__(self):
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _follow(self):
        """Take labels and edits as they are now, while somebody else may change them."""
        for _ in range(_TRIES):
            marks = self._look()
            try:
                content = read_journal(self.journal_path, self._base.uuid, self._base.face_count)
            except MapFileError as error:
                note = "its label edits are not shown: %s" % error
                if note not in self.notes:
                    self.notes.append(note)
                content = None
            if content is not None and content.damaged:
                note = "%d damaged lines of its label edits in %s are not shown"
                note %= len(content.damaged), self.journal_path
                if note not in self.notes:
                    self.notes.append(note)
            self._base.refresh()
            if self._look() == marks:
                break
        self._marks = marks
        self._edits = content.edits if content else {}
        self._owner = content.owner if content else None
        self._find_names()

    def _look(self):
        return stamp(self.journal_path), stamp(self._base.path)

    def _refresh(self):
        if self._journal is None:
            if self._look() != self._marks:
                self._follow()
        elif self._base.refresh():
            self._find_names()

    def _find_names(self):
        gone = {text for text, label in self._edits.items() if label is None}
        self._names = NaturalNames((self._base.names | set(self._edits)) - gone)

    def _current(self, text):
        return self._edits[text] if text in self._edits else self._base.get(text)

    def _readable(self, text):
        """The label; None where there is none, or it cannot be read."""
        try:
            return self._current(text)
        except MapFileError as error:
            if error.code in ("changed", "crashed", "timeout"):
                raise  # that is no property of the label
            return None

    def _unknown(self, text):
        names = self.names()
        near = difflib.get_close_matches(text[:80], names[:10000], n=3)
        if near:
            hint = "did you mean %s?" % ", ".join(near)
        else:
            more = ", ... (%d in all)" % len(names) if len(names) > 5 else ""
            hint = "labels: %s%s" % (", ".join(names[:5]) or "none", more)
        return MapFileError("label", self.path, "there is no label %r" % text[:80], hint)

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
        self._mend_journal()
        self._journal.append(text, label)
        self._edits[text] = label
        if label is None:
            self._names.discard(text)
        else:
            self._names.add(text)
        if self._journal.size > self._compact_at:
            self._compact()

    def _mend_journal(self):
        """Write it anew if somebody else has changed it: edits in it are said to be safe."""
        fault = self._journal.fault()
        if fault:
            self._journal.rewrite(self._edits)
            self._mended = "%s was %s by another program, and is written anew with all %d edits"
            self._mended %= self.journal_path, fault, len(self._edits)

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
        if rest or self._journal.fault():
            self._journal.rewrite(rest)
        else:
            self._journal.clear()
        self._edits = rest
        self._find_names()
        self._compact_at = _SMALL
