"""Work that nobody waits for."""

import logging
import threading
from typing import Callable

from mesh_map.base.errors import PLUGIN_FAILURES, error_line

_LOG = logging.getLogger("mesh_map")


class BackgroundWork:
    """Work that is done in a thread of its own, which lives while there is some. For any thread."""

    def __init__(self, work: Callable[[], None], name: str) -> None:
        """
        Args:
            work: all that there is to do; what it raises is logged.
            name: of the thread.
        """
        self._work, self._name = work, name
        self._lock = threading.Lock()  # held for moments
        self._asked = self._working = False

    def ask(self) -> None:
        """From now on, work() is called once more at least; by one thread, one call at a time."""
        with self._lock:
            self._asked = True
            if not self._working:
                self._working = True
                threading.Thread(target=self._run, name=self._name, daemon=True).start()

    def _run(self) -> None:
        while self._is_asked():
            try:
                self._work()
            except PLUGIN_FAILURES as error:
                _LOG.error("%s: %s", self._name, error_line(error))

    def _is_asked(self) -> bool:
        with self._lock:
            self._working, self._asked = self._asked, False
            return self._working
