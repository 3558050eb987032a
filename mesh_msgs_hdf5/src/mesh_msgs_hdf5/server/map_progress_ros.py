"""What hdf5_map_server says of itself on the topic "progress"."""
import os
import threading
from typing import Dict, Iterable, List, Sequence

import rospy
from std_msgs.msg import String

from mesh_msgs.diagnostics_ros import ERROR, OK, WARN, Status
from mesh_msgs.text import one_line
from mesh_msgs_hdf5.labels.journal_reading import owner_text
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.server.served_map import ServedMap


class MapProgress:
    """Says what is being read, then what is served. Latched; safe for threads.

    One fact a line: "reading FILE (SIZE)" while it is read; then "ready: serving ..." for each map,
    with "note: ..." (what reading it changed), "labels: ..." (where edits of labels go, if that is
    another process) and "failed: ..." (why a newer file is not served).
    """

    def __init__(self) -> None:
        self._publisher = rospy.Publisher("progress", String, latch=True, queue_size=10)
        self._lock = threading.Lock()
        self._notes: Dict[str, List[str]] = {}
        self._failures: Dict[str, str] = {}
        self._descriptions: Dict[str, str] = {}
        self._said = ""

    def reading(self, path: str, waits: str = "") -> None:
        """A file is going to be read; waits: as soon as this is over."""
        if waits:
            self._say("reading %s" % one_line("%s, but %s" % (path, waits)))
            return
        try:
            size = " (%.1f MB)" % (os.stat(path).st_size / 1e6)
        except OSError:
            size = ""
        self._say("reading %s%s" % (one_line(path), size))

    def loaded(self, path: str, notes: Sequence[str]) -> None:
        """It has been; what is there to be said of that."""
        self._notes[path] = [one_line(note) for note in notes]
        self._failures.pop(path, None)

    def say_notes(self, served: ServedMap) -> None:
        """What is bad in the file, and not served as it stands there: once, also in the log."""
        for note in served.new_notes():
            rospy.logwarn("%s", one_line("%s: %s" % (served.name, note)))
            self._notes.setdefault(served.path, []).append(one_line(note))

    def serves(self, served: ServedMap) -> None:
        """A map has been published; ready() does not look into its file."""
        try:
            self._descriptions[served.uuid] = one_line(served.describe())
        except MapFileError:  # it has just been replaced; that will be looked at
            self._descriptions[served.uuid] = "serving " + one_line(served.name)

    def describe(self) -> List[str]:
        """Sentences about the maps that are served, for the log."""
        return list(self._descriptions.values())

    def failed(self, path: str, why: str) -> None:
        """A newer file is not served; "": nothing newer is there any more."""
        if why:
            self._failures[path] = one_line(why)
        else:
            self._failures.pop(path, None)

    def ready(self, maps: Iterable[ServedMap]) -> None:
        """These maps are served; to be called now and then, since owners of labels end."""
        lines, descriptions = [], {}
        for served in maps:
            descriptions[served.uuid] = self._descriptions.get(served.uuid, served.name)
            lines.append("ready: %s" % descriptions[served.uuid])
            lines += ["note: %s" % note for note in self._notes.get(served.path, ())]
            owner = served.labels.owner
            if owner is not None:
                lines.append("labels: edits of labels are sent to %s" % owner_text(owner))
            if served.path in self._failures:
                lines.append("failed: %s" % self._failures[served.path])
        self._descriptions = descriptions
        self._say("\n".join(lines))

    def status(self, unsaved: Sequence[str] = (), refused: str = "") -> Status:
        """For /diagnostics. unsaved: sentences about what could not be saved. refused: what was
        refused a short while ago; "" if nothing."""
        lines = self._said.split("\n")
        failures = [line for line in lines if line.startswith("failed: ")] + list(unsaved)
        if failures:
            return Status(ERROR, "; ".join(failures))
        served = sum(line.startswith("ready: ") for line in lines)
        if not served:
            return Status(WARN, self._said or "starting")
        if refused:
            return Status(WARN, refused, dict(self._descriptions))
        return Status(OK, "maps that are served: %d" % served, dict(self._descriptions))

    def _say(self, text: str) -> None:
        with self._lock:
            if text != self._said:
                self._said = text
                self._publisher.publish(String(data=text))
