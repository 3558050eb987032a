"""What our nodes tell on /diagnostics, for robot monitors and whoever watches a robot."""

import threading
import time
from typing import Any, Callable, List, Mapping, NamedTuple

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import Updater

from mesh_msgs.text import one_line

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
PERIOD = 1.0  # seconds between two messages where nothing changes
LOOK = 0.1  # seconds between two looks


class Status(NamedTuple):
    """How a part of a node is.

    level: OK, WARN or ERROR.
    message: one line for people.
    values: details, shown as texts.
    """

    level: int
    message: str
    values: Mapping[str, Any] = {}


class _Updater(Updater):
    def addedTaskCallback(self, task: Any) -> None:
        """Without the base class's message that all is well before anybody has looked."""


class Diagnostics:
    """Tells how a part of this node is: once a second by the clock on the wall, and at once when it
    changes. The name on /diagnostics is "<node>: <part>"."""

    def __init__(
        self,
        part: str,
        look: Callable[[], Status],
        on_change: Callable[[Status], None] = lambda status: None,
    ) -> None:
        """
        Args:
            part: what it is about.
            look: called often, in a thread of its own: it must not wait for anything.
            on_change: called in that thread with each status of another level or message.
        """
        self._look, self._on_change = look, on_change
        self._status = Status(WARN, "starting")
        self._updater = _Updater()
        self._updater.setHardwareID("none")
        self._updater.add(part, self._fill)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="diagnostics", daemon=True)
        self._thread.start()

    def shutdown(self) -> None:
        """Ends it; further calls have no effect."""
        self._closed.set()
        if threading.current_thread() is not self._thread:
            self._thread.join(PERIOD)

    def _run(self) -> None:
        due = time.monotonic()
        told: List[Any] = []
        while not (self._closed.wait(LOOK) or rospy.is_shutdown()):
            try:
                self._status = self._looked()
                changed = told != list(self._status[:2])
                if changed:
                    told = list(self._status[:2])
                    self._on_change(self._status)
                if changed or time.monotonic() >= due:
                    due = time.monotonic() + PERIOD
                    self._updater.force_update()
            except rospy.ROSException:  # a shutdown closes topics before it says so
                pass

    def _looked(self) -> Status:
        try:
            return self._look()
        except Exception as error:  # whatever it is, it is no reason to fall silent
            return Status(ERROR, "%s: %s" % (type(error).__name__, one_line(error)))

    def _fill(self, stat: Any) -> Any:
        stat.summary(self._status.level, one_line(self._status.message))
        for name, value in self._status.values.items():
            stat.add(str(name), one_line(value))
        return stat
