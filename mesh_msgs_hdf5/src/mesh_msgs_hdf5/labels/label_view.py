"""Labels with the edits of a journal on top, as somebody sees them who does not change them."""
import difflib
import threading
from typing import Any, Dict, List, Optional

from mesh_msgs_hdf5.errors import MapFileError
from mesh_msgs_hdf5.label_names import split_label
from mesh_msgs_hdf5.labels.journal_reading import is_owned, read_journal
from mesh_msgs_hdf5.labels.natural_names import NaturalNames
from mesh_msgs_hdf5.mesh import Label
from mesh_msgs_hdf5.writing.save import stamp

_TRIES = 5


class LabelView:
    """The labels of one mesh, as they are at each call.

    base: labels without the edits (LabelBase, or what has its members). Attributes: journal_path,
    notes (sentences for the user).
    """

    def __init__(self, base: Any, journal_path: str) -> None:
        """Nothing is read before _follow()."""
        self._base = base
        self._lock = threading.RLock()
        self._edits: Dict[str, Optional[Label]] = {}
        self._names = NaturalNames()
        self._owner: Optional[Dict[str, Any]] = None
        self._marks: Any = None
        self.journal_path = journal_path
        self.notes: List[str] = []

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
        if not is_owned(self.journal_path):
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
        """Text -> label, in the order of names()."""
        with self._lock:
            names, labels = self.names(), self._base.all()
            labels.update(self._edits)
            return {text: labels[text] for text in names}

    def groups(self) -> List[str]:
        """The classes of all labels: their texts before the first underscore."""
        return list(dict.fromkeys(split_label(text)[0] for text in self.names()))

    def group(self, class_name: str) -> Dict[str, Label]:
        """The labels of exactly that class; empty if there is none."""
        with self._lock:
            texts = [text for text in self.names() if split_label(text)[0] == class_name]
            return {text: self._current(text) for text in texts}

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
        if self._look() != self._marks:
            self._follow()

    def _find_names(self):
        gone = {text for text, label in self._edits.items() if label is None}
        self._names = NaturalNames((self._base.names | set(self._edits)) - gone)

    def _current(self, text):
        return self._edits[text] if text in self._edits else self._base.get(text)

    def _unknown(self, text):
        names = self.names()
        near = difflib.get_close_matches(text[:80], names[:10000], n=3)
        if near:
            hint = "did you mean %s?" % ", ".join(near)
        else:
            more = ", ... (%d in all)" % len(names) if len(names) > 5 else ""
            hint = "labels: %s%s" % (", ".join(names[:5]) or "none", more)
        return MapFileError("label", self.path, "there is no label %r" % text[:80], hint)
