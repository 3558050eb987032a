"""One map of a server: its file, what was received since, its labels."""
import dataclasses
import os
import threading
from typing import Any, Callable, List, Optional, Set, Tuple, Union

import genpy

from mesh_msgs_hdf5.files.save import stamp as file_stamp
from mesh_msgs_hdf5.formats.any_mesh import MeshMembers
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.labels.fixed_labels import FixedLabels
from mesh_msgs_hdf5.labels.journal_reading import owner_text
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit, is_empty
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.ros.map_messages import MapMessages
from mesh_msgs_hdf5.server.map_overlay import MapOverlay
from mesh_msgs_hdf5.server.pending import Pending, Sent
from mesh_msgs_hdf5.server.received import Received, Refused
from mesh_msgs_hdf5.server.server_options import MapRequest

_PLURALS = {
    "vertex_costs": "layers",
    "face_attributes": "face cost layers",
    "textures": "textures",
}

# in what the owner of the labels of a map says of itself: it stores all else of the map, too
STORES_ALL = "stores_all"


class ServedMap:
    """A map that is served and to which changes are made.

    Changes are served at once and kept in memory until save() has put them into the file.

    Attributes: overlay (the map with its changes), messages (made of it), labels, uuid, path,
    request (loads it once more), loaded_stamp (of the path when it was loaded, or published once
    more; see files.save.stamp), target (the map file that changes go to: the map itself, or one
    beside it; see label_target), saved_stamp (of the target as this object has left it),
    is_ended (nothing is stored any more).

    Args:
        request: the file that was asked for (its path is that of the map; that of the overlay is
            the target where that is there), and the one part of it.
        stamp: for the headers of its messages.
        locked: why nothing may be stored; "" if it may.
    """

    def __init__(
        self,
        request: MapRequest,
        overlay: MapOverlay,
        labels: Union[LabelStore, FixedLabels],
        stamp: genpy.Time,
        locked: str = "",
    ) -> None:
        self.request, self.path = request, request.path
        self.overlay = overlay
        self.labels = labels
        self.messages = MapMessages(overlay, overlay.uuid, stamp)
        self.uuid = overlay.uuid
        self.target = labels.path
        self._locked = locked
        self.pending = Pending()
        self.is_ended = False
        self.loaded_stamp: Any = None
        self.saved_stamp: Any = None
        self._said: Set[str] = set()
        self._saving = threading.Lock()
        self._changing = threading.Lock()

    @property
    def name(self) -> str:
        """For log lines: the file, and its part where that is not "mesh"."""
        part = self.overlay.part
        return self.path if part in ("mesh", "") else "%s, part %s" % (self.path, part)

    def describe(self) -> str:
        """What is served, in one line."""
        overlay = self.overlay
        return "serving %s: %d vertices, %d faces, layers: %s, frame %s, uuid %s" % (
            self.name,
            overlay.vertex_count,
            overlay.face_count,
            ", ".join(overlay.layer_names()) or "none",
            overlay.frame_id,
            overlay.uuid,
        )

    def new_notes(self) -> List[str]:
        """What was left out or mended in what was read of the file so far, each said once."""
        notes = list(self.overlay.notes)
        if isinstance(self.labels, LabelStore):
            notes += self.labels.file_notes()
        new = [note for note in dict.fromkeys(notes) if note not in self._said]
        self._said.update(new)
        return new

    def store(
        self,
        read: Callable[[Any, Any], Received],
        message: Any,
        stamp: genpy.Time,
        sent: Optional[Sent] = None,
    ) -> Received:
        """Make the change that a function of module received reads from a message.

        stamp: of what is served from now on. sent: the message is pending as this. Raises Refused
        where the message is wrong or nothing may be stored, and MapFileError.
        """
        with self._changing:  # an update of a layer reads what it changes
            self.check_open()
            received = read(message, self.overlay)
            self.overlay.change(received.edit)
            if sent is not None:
                self.pending.add(received.member, sent)
        self.messages.touch(received.member, received.key, stamp)
        return received

    def check_open(self) -> None:
        """Raises Refused where nothing may be stored."""
        if self._locked:
            raise Refused(self._locked)
        owner = self.labels.owner
        if owner is not None and owner.get(STORES_ALL):
            raise Refused("%s belongs to %s: store it there" % (self.name, owner_text(owner)))

    def end(self, why: str) -> None:
        """Store nothing any more; why is for the senders. What was stored can be saved."""
        with self._changing:
            self._locked, self.is_ended = self._locked or why, True

    @property
    def is_saved(self) -> bool:
        """True if everything received, labels apart, is in the file."""
        return is_empty(self.overlay.unsaved)

    def save(self) -> Tuple[str, str]:
        """Put what was received, labels apart, into the file, in one step.

        Returns what has been saved ("2 layers, materials"; "" if there was nothing), and what has
        to wait and why ("" if nothing). Raises MapFileError; then the file is as before, and
        everything is kept for the next time.
        """
        with self._saving:
            with self._changing:  # a message is pending once its change is in the overlay
                ready, waits = self._ready()
                sent = self.pending.now(but=("materials",) if waits else ())
            if is_empty(ready):
                return "", waits
            try:
                self._write(ready)
            except MapFileError as error:
                if error.code not in ("changed", "missing"):
                    raise
                raise MapFileError(
                    *error.args[:3], "put the old file back, then it is saved"
                ) from error
            self.overlay.saved(ready)
            self.pending.store(sent)
            return summary(ready), waits

    def is_changed(self, found: Any) -> bool:
        """Whether another program left the file with this stamp, and has not touched it since;
        waits for a save that is under way."""
        with self._saving:
            return found != self.saved_stamp and found == file_stamp(self.path)

    def fold_labels(self) -> Tuple[str, str]:
        """Put the label edits into the file; as save(): "3 labels", and nothing has to wait."""
        with self._saving:
            dirty, before = self.labels.dirty, file_stamp(self.target)
            count = self.labels.save() if dirty else 0
            if dirty:
                self._note_saved(before)
        return "%d label%s" % (count, "" if count == 1 else "s") if count else "", ""

    def _ready(self):
        """What can be saved now: a file refuses materials whose textures it does not have."""
        edit = self.overlay.unsaved
        if edit.materials is None:
            return edit, ""
        used = {int(index) for index in edit.materials.texture_indices if index >= 0}
        missing = sorted(used - set(self.overlay.texture_indices()))
        if not missing:
            return edit, ""
        shown = ", ".join(map(str, missing[:10])) + (", ..." if len(missing) > 10 else "")
        waits = "materials wait for the textures %s: send them on store/texture" % shown
        return dataclasses.replace(edit, materials=None), waits

    def _write(self, edit):
        with self.overlay.lock:
            if os.path.realpath(self.overlay.source.path) != self.target:
                self._make_target(edit)
            before = file_stamp(self.target)
            try:
                self.overlay.source.update(edit)
            except MapFileError as error:
                if error.code != "changed":
                    raise
                self.overlay.source.update(edit)  # another program had only saved it meanwhile
            self._note_saved(before)

    def _note_saved(self, before):
        """What another program had changed before is to be published: then the file is not ours."""
        if before in (None, self.saved_stamp, self.loaded_stamp):
            self.saved_stamp = file_stamp(self.target)

    def _make_target(self, edit):
        source = self.overlay.source
        if not os.path.exists(self.target):
            if isinstance(source, MeshMembers):
                MapFile.write(self.target, source.read(), overwrite=False)
            else:
                isolated("convert", source.path, self.target, part=source.part)
        target = IsolatedMapFile(self.target)
        if target.uuid != self.uuid:
            raise MapFileError(
                "exists",
                self.target,
                "changes of %s belong here, but it holds another mesh" % self.path,
                "rename one of them",
            )
        self.overlay.source = target


def summary(edit: Edit) -> str:
    """What a change is of, for a log line: "2 layers, vertex colors"."""
    words: List[str] = []
    for name, value in vars(edit).items():
        if name in _PLURALS and value:
            plural = _PLURALS[name]
            words.append("%d %s" % (len(value), plural[:-1] if len(value) == 1 else plural))
        elif value is not None and not isinstance(value, (dict, frozenset)):
            words.append(name.replace("_", " "))
    words += ["no " + name.replace("_", " ") for name in sorted(edit.remove)]
    return ", ".join(words)
